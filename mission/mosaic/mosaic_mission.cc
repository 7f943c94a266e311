// SPDX-License-Identifier: Apache-2.0
#include "mission/mosaic/mosaic_mission.h"

#include "mission/mosaic/mosaic_records.h"
#include "mission/mosaic/mosaic_report.h"
#include "mission/path/path_records.h"

namespace kestrel::mission {
namespace {

vision::MosaicOptions OptionsOf(const MosaicFlight& flight) {
  vision::MosaicOptions options;
  options.model = flight.model, options.surface = flight.surface;
  return options;
}

class MosaicMission final : public Mission {
 public:
  MosaicMission(const MosaicFlight& flight, const MissionParts& parts)
      : flight_(flight),
        pilot_(flight.height_m, flight.path, flight.plan),
        mosaic_(OptionsOf(flight), flight.mosaic, parts.camera, parts.X_BC, flight.images) {}

  Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    Decision decision;
    auto report = std::make_shared<MosaicReport>();
    mosaic_.Note(state);
    report->reference = pilot_.Fly(state, decision);
    if (pilot_.path() && mosaic_.offered() < flight_.images && pilot_.path_s(state) >= Due_s())
      report->step = mosaic_.Add(frame, decision);
    phase_ = decision.phase;
    if (pilot_.AtEnd(state)) {
      report->finished = mosaic_.Finish();
      decision.outcome = flight_.outcome;
      made_ = mosaic_.placed() > 0;
    }
    mosaic_.Fill(*report);
    decision.report = report;
    return decision;
  }
  bool Accomplished() const override { return made_; }
  TargetNeed Target() const override { return TargetNeed::kNone; }
  void Draw(cv::Mat&) const override {}
  std::vector<Caption> Captions() const override {
    std::vector<Caption> captions = mosaic_.Captions();
    captions.insert(captions.begin(), {std::string(phase_)});
    return captions;
  }
  cv::Mat ProductImage() const override { return mosaic_.ProductImage(); }
  void WriteProducts(const std::filesystem::path& folder) const override { mosaic_.WriteProducts(folder); }

 private:
  // When the next image is due, since the path's beginning.
  double Due_s() const {
    const WaypointPath& path = *pilot_.path();
    const double from_s = path.arrival_s(1) + path.waypoints()[1].hold_s,
                 until_s = path.duration_s() - path.waypoints().back().hold_s;
    return from_s + (until_s - from_s) * mosaic_.offered() / (flight_.images - 1);
  }

  MosaicFlight flight_;
  PathPilot pilot_;
  MosaicObserver mosaic_;
  std::string_view phase_;
  bool made_ = false;
};

}  // namespace

std::unique_ptr<Mission> MakeMosaicMission(const MosaicFlight& flight, const MissionParts& parts) {
  return std::make_unique<MosaicMission>(flight, parts);
}

MissionType MosaicMissionType(
    const std::string& name, const std::string& summary, const std::vector<Metric>& metrics,
    const std::function<void(const std::vector<LogRow>&, std::map<std::string, double>&)>& add_metrics) {
  MissionType type{.name = name, .summary = summary};
  for (const auto& columns : {PathColumns(), MosaicColumns()})
    type.telemetry.insert(type.telemetry.end(), columns.begin(), columns.end());
  for (const auto& more : {PathMetrics(), MosaicMetrics(), metrics})
    type.metrics.insert(type.metrics.end(), more.begin(), more.end());
  type.add_metrics = [add_metrics](const std::vector<LogRow>& rows, std::map<std::string, double>& values) {
    AddPathMetrics(rows, values);
    AddMosaicMetrics(rows, values);
    add_metrics(rows, values);
  };
  type.products = MosaicProducts();
  type.product_video = "mosaic.mp4";
  return type;
}

}  // namespace kestrel::mission
