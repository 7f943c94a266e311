// SPDX-License-Identifier: Apache-2.0
#include "scenarios/panorama/panorama.h"

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
#include "scenarios/panorama/panorama_metrics.h"

namespace kestrel::scenarios {
namespace {

constexpr double kSettle_s = 3;  // before the turn, and after it

vision::MosaicOptions AllAround() {
  vision::MosaicOptions options;
  options.model = vision::MosaicModel::kRotation;
  options.surface = vision::Surface::kSphere;
  return options;
}

std::vector<mission::Waypoint> Turn(const PanoramaFlight& flight, const Eigen::Vector3d& p_N, double yaw) {
  const Eigen::Vector3d spot(p_N.x(), p_N.y(), -flight.height_m);
  return {{p_N, yaw, 0, "approach"},
          {spot, yaw, kSettle_s, "hover"},
          {spot, yaw + Radians(flight.turn_deg), kSettle_s, "turn"}};
}

class PanoramaMission final : public mission::Mission {
 public:
  PanoramaMission(const PanoramaFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        pilot_(flight.height_m, flight.path,
               [flight](const Eigen::Vector3d& p_N, double yaw) { return Turn(flight, p_N, yaw); }),
        mosaic_(AllAround(), flight.mosaic, parts.camera, parts.X_BC, flight.images) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    auto report = std::make_shared<mission::MosaicReport>();
    mosaic_.Note(state);
    report->reference = pilot_.Fly(state, decision);
    if (pilot_.path() && mosaic_.offered() < flight_.images && Turning_s(state) >= Due_s())
      report->step = mosaic_.Add(frame, decision);
    phase_ = decision.phase;
    if (pilot_.AtEnd(state)) {
      report->finished = mosaic_.Finish();
      decision.outcome = "turned";
      turned_ = mosaic_.placed() > 0;
    }
    mosaic_.Fill(*report);
    decision.report = report;
    return decision;
  }
  bool Accomplished() const override { return turned_; }
  // It flies by the autopilot's own state, and the mosaic is made beside that.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }
  void Draw(cv::Mat& bgr) const override {
    mission::Caption(bgr, 0, std::string(phase_));
    mosaic_.Draw(bgr);
  }
  cv::Mat ProductImage() const override { return mosaic_.ProductImage(); }
  void WriteProducts(const std::filesystem::path& folder) const override { mosaic_.WriteProducts(folder); }

 private:
  double Turning_s(const control::VehicleState& state) const {
    return pilot_.path_s(state) - pilot_.path()->arrival_s(1) - kSettle_s;
  }
  double Due_s() const {
    const double all_s = pilot_.path()->arrival_s(2) - pilot_.path()->arrival_s(1) - kSettle_s;
    return all_s * mosaic_.offered() / (flight_.images - 1);
  }

  PanoramaFlight flight_;
  mission::PathPilot pilot_;
  mission::MosaicObserver mosaic_;
  std::string_view phase_;
  bool turned_ = false;
};

}  // namespace

mission::MissionType TypeOf(const PanoramaFlight&) {
  std::vector<mission::TelemetryColumn> columns = mission::PathColumns();
  for (const mission::TelemetryColumn& each : mission::MosaicColumns()) columns.push_back(each);
  std::vector<mission::Metric> metrics = mission::PathMetrics();
  for (const auto& more : {mission::MosaicMetrics(), PanoramaMetrics()})
    metrics.insert(metrics.end(), more.begin(), more.end());
  return {.name = "panorama",
          .summary = "Turns on the spot while a panorama of all that is around grows.",
          .telemetry = std::move(columns),
          .metrics = std::move(metrics),
          .add_metrics =
              [](const std::vector<mission::LogRow>& rows, std::map<std::string, double>& values) {
                mission::AddPathMetrics(rows, values);
                mission::AddMosaicMetrics(rows, values);
                AddPanoramaMetrics(rows, values);
              },
          .plots = {{"path.png", records::FliesPath, records::PathPlot},
                    {"growth.png", records::MakesMosaic, records::GrowthPlot}},
          .products = mission::MosaicProducts(),
          .product_video = "mosaic.mp4"};
}

void CheckFlightLimits(const PanoramaFlight& flight, const mission::AircraftLimits& limits,
                       const Place& where, Mistakes& mistakes) {
  mission::CheckPathLimits(flight.path, limits, where, mistakes);
}

bool FlightCanHave(const PanoramaFlight& flight, const std::string& metric, const mission::Varies& varies) {
  if (metric == "panorama_closure_deg") return flight.turn_deg >= 360 || varies("flight.turn_deg");
  if (metric.starts_with("chain_"))
    return (flight.mosaic.chain || varies("flight.mosaic.chain")) &&
           (metric != "chain_closure_deg" || flight.turn_deg >= 360 || varies("flight.turn_deg"));
  return true;
}

std::unique_ptr<mission::Mission> MakeMission(const PanoramaFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<PanoramaMission>(flight, parts);
}

}  // namespace kestrel::scenarios
