// SPDX-License-Identifier: Apache-2.0
#include "scenarios/attitude/attitude.h"

#include <cmath>
#include <optional>

#include "geometry/tait_bryan.h"
#include "mission/horizon_observer.h"
#include "mission/horizon_records.h"
#include "records/plot/horizon_plot.h"
#include "vision/horizon/baseline/skyline_baseline.h"

namespace kestrel::scenarios {
namespace {

class AttitudeMission final : public mission::Mission {
 public:
  AttitudeMission(const AttitudeFlight& flight, const vision::CameraModel& camera, const Pose& X_BC,
                  const cv::Mat& forbidden, std::uint64_t seed)
      : flight_(flight), pilot_(flight.manoeuvres, seed), watch_(camera, X_BC, forbidden) {
    if (!flight.baseline) return;
    skyline_baseline_.emplace(camera, X_BC.R.toRotationMatrix());
    compass_baseline_.emplace(
        camera, vision::GroundRing(camera, X_BC.R.toRotationMatrix(), flight.baseline_px_per_deg));
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    auto report = std::make_shared<mission::HorizonReport>(watch_.Observe(frame, state, decision));
    if (skyline_baseline_) Compare(frame, *report);
    decision.report = report;
    Steer(state, decision);
    phase_ = decision.phase;
    return decision;
  }
  bool Accomplished() const override { return watch_.seen(); }
  // The skyline is measured, and nothing flown by it.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }
  void Draw(cv::Mat& bgr) const override { watch_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return watch_.Captions(phase_); }

 private:
  // The reference method, on the same image.
  void Compare(const vision::Frame& frame, mission::HorizonReport& report) {
    mission::AttitudeFix fix{};
    fix.turned = compass_baseline_->Turn(frame.image);
    if (const auto attitude = skyline_baseline_->Measure(frame.image)) {
      fix.roll = attitude->roll, fix.pitch = attitude->pitch;
      report.baseline = fix;
    }
  }

  void Steer(const control::VehicleState& state, mission::Decision& decision) {
    if (!home_N_) home_N_ = state.p_NB, home_yaw_ = YawOf(state.R_NB);
    if (state.landed && state.t_s < flight_.take_off_s) {
      decision.phase = "run up";
      return;
    }
    if (state.t_s < flight_.manual_from_s) {
      const bool from_ground = flight_.take_off_s > 0;
      decision.phase = from_ground ? "take off" : "hold";
      decision.setpoint = control::PositionSetpoint{
          {home_N_->x(), home_N_->y(), home_N_->z() - (from_ground ? flight_.take_off_height_m : 0)},
          home_yaw_};
      return;
    }
    decision.phase = "by hand";
    decision.setpoint = pilot_.Fly(state, {home_N_->x(), home_N_->y(), 0});
  }

  AttitudeFlight flight_;
  ManualPilot pilot_;
  mission::HorizonObserver watch_;
  std::optional<vision::SkylineBaseline> skyline_baseline_;
  std::optional<vision::CompassBaseline> compass_baseline_;
  std::optional<Eigen::Vector3d> home_N_;
  double home_yaw_ = 0;
  std::string_view phase_;
};

}  // namespace

mission::MissionType TypeOf(const AttitudeFlight&) {
  return {.name = "attitude",
          .summary = "Measures attitude and heading by the skyline while the autopilot or a pilot flies.",
          .telemetry = mission::HorizonColumns(),
          .metrics = mission::HorizonMetrics(),
          .add_metrics = mission::AddHorizonMetrics,
          .plots = {{"attitude.png", records::MeasuresAttitude, records::HorizonPlot}}};
}

bool FlightCanHave(const AttitudeFlight& flight, const std::string& metric, const mission::Varies& varies) {
  return !metric.starts_with("baseline_") || flight.baseline || varies("flight.baseline");
}

std::unique_ptr<mission::Mission> MakeMission(const AttitudeFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<AttitudeMission>(flight, parts.camera, parts.X_BC, parts.own_parts, parts.seed);
}

}  // namespace kestrel::scenarios
