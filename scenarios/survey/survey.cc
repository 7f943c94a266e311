// SPDX-License-Identifier: Apache-2.0
#include "scenarios/survey/survey.h"

#include <cmath>
#include <string>

#include "geometry/tait_bryan.h"
#include "mission/caption.h"
#include "mission/mosaic/mosaic_records.h"
#include "mission/mosaic/mosaic_report.h"
#include "mission/path/path_pilot.h"
#include "mission/path/path_records.h"
#include "records/plot/growth_plot.h"
#include "records/plot/path_plot.h"
#include "scenarios/survey/survey_metrics.h"

namespace kestrel::scenarios {
namespace {

constexpr double kSettle_s = 2;  // at the beginning of the first line

vision::MosaicOptions GroundMosaic() {
  vision::MosaicOptions options;
  options.model = vision::MosaicModel::kPlane;
  options.surface = vision::Surface::kPlane;
  return options;
}

class SurveyMission final : public mission::Mission {
 public:
  SurveyMission(const SurveyFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        pilot_(flight.height_m, flight.path,
               [flight](const Eigen::Vector3d& p_N, double yaw) { return SurveyLines(flight, p_N, yaw); }),
        mosaic_(GroundMosaic(), flight.mosaic, parts.camera, parts.X_BC, flight.images) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    auto report = std::make_shared<mission::MosaicReport>();
    mosaic_.Note(state);
    report->reference = pilot_.Fly(state, decision);
    if (pilot_.path() && mosaic_.offered() < flight_.images && Lines_s(state) >= Due_s())
      report->step = mosaic_.Add(frame, decision);
    phase_ = decision.phase;
    if (pilot_.AtEnd(state)) {
      report->finished = mosaic_.Finish();
      decision.outcome = "surveyed";
      surveyed_ = mosaic_.placed() > 0;
    }
    mosaic_.Fill(*report);
    decision.report = report;
    return decision;
  }
  bool Accomplished() const override { return surveyed_; }
  // It flies by the autopilot's own state, and the mosaic is made beside that.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }
  void Draw(cv::Mat& bgr) const override {
    mission::Caption(bgr, 0, std::string(phase_));
    mosaic_.Draw(bgr);
  }
  cv::Mat ProductImage() const override { return mosaic_.ProductImage(); }
  void WriteProducts(const std::filesystem::path& folder) const override { mosaic_.WriteProducts(folder); }

 private:
  // Since the beginning of the first line, which is the second waypoint.
  double Lines_s(const control::VehicleState& state) const {
    return pilot_.path_s(state) - pilot_.path()->arrival_s(1) - kSettle_s;
  }
  double Due_s() const {
    const double all_s = pilot_.path()->duration_s() - pilot_.path()->arrival_s(1) - 2 * kSettle_s;
    return all_s * mosaic_.offered() / (flight_.images - 1);
  }

  SurveyFlight flight_;
  mission::PathPilot pilot_;
  mission::MosaicObserver mosaic_;
  std::string_view phase_;
  bool surveyed_ = false;
};

}  // namespace

std::vector<mission::Waypoint> SurveyLines(const SurveyFlight& flight, const Eigen::Vector3d& p_N,
                                           double yaw) {
  const double heading = Radians(flight.heading_deg);
  const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0), right(-along.y(), along.x(), 0);
  const Eigen::Vector3d begin(flight.begin_m.x(), flight.begin_m.y(), -flight.height_m);
  const double turned = yaw + WrapAngle(heading - yaw);
  std::vector<mission::Waypoint> path = {{p_N, yaw, 0, "approach"}, {begin, turned, kSettle_s, "approach"}};
  for (int line = 0; line < flight.lines; ++line) {
    const bool out = line % 2 == 0;
    const Eigen::Vector3d first = begin + line * flight.spacing_m * right;
    const Eigen::Vector3d far = first + flight.line_m * along;
    if (line > 0) path.push_back({out ? first : far, turned, 0, "shift"});
    path.push_back({out ? far : first, turned, 0, "line"});
  }
  path.back().hold_s = kSettle_s;
  return path;
}

mission::MissionType TypeOf(const SurveyFlight&) {
  std::vector<mission::TelemetryColumn> columns = mission::PathColumns();
  for (const mission::TelemetryColumn& each : mission::MosaicColumns()) columns.push_back(each);
  std::vector<mission::Metric> metrics = mission::PathMetrics();
  for (const auto& more : {mission::MosaicMetrics(), SurveyMetrics()})
    metrics.insert(metrics.end(), more.begin(), more.end());
  return {.name = "survey",
          .summary = "Flies over the ground in lines while a mosaic of it grows.",
          .telemetry = std::move(columns),
          .metrics = std::move(metrics),
          .add_metrics =
              [](const std::vector<mission::LogRow>& rows, std::map<std::string, double>& values) {
                mission::AddPathMetrics(rows, values);
                mission::AddMosaicMetrics(rows, values);
                AddSurveyMetrics(rows, values);
              },
          .plots = {{"path.png", records::FliesPath, records::PathPlot},
                    {"growth.png", records::MakesMosaic, records::GrowthPlot}},
          .products = mission::MosaicProducts(),
          .product_video = "mosaic.mp4"};
}

void CheckFlightLimits(const SurveyFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes) {
  mission::CheckPathLimits(flight.path, limits, where, mistakes);
}

bool FlightCanHave(const SurveyFlight& flight, const std::string& metric, const mission::Varies& varies) {
  if (metric.starts_with("chain_")) return flight.mosaic.chain || varies("flight.mosaic.chain");
  if (metric == "georeference_rmse_m") return flight.mosaic.poses || varies("flight.mosaic.poses");
  return true;
}

std::unique_ptr<mission::Mission> MakeMission(const SurveyFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<SurveyMission>(flight, parts);
}

}  // namespace kestrel::scenarios
