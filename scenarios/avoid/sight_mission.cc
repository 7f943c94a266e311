// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/sight_mission.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"
#include "mission/command_arrows.h"
#include "scenarios/avoid/avoid_report.h"
#include "vision/capture/frozen_image.h"

namespace kestrel::scenarios {
namespace {

class SightMission final : public mission::Mission {
 public:
  SightMission(const AvoidFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        X_BC_(parts.X_BC),
        watch_(parts.camera, parts.X_BC, flight.marks.front(), vision::BalloonMeasure::kCamShift) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    const auto start = std::chrono::steady_clock::now();
    watch_.Observe(frame, state, frozen_.Is(frame.image));
    decision.vision_s = SecondsSince(start);
    decision.target = watch_.status();
    decision.fix_age_s = watch_.age_s();
    if (!down_m_) down_m_ = state.p_NB.z();
    if (state.t_s >= flight_.end_s) {
      phase_ = "ended";
      decision.outcome = "ended by hand";
      command_ = {};
    } else {
      Fly(state, decision);
    }
    decision.setpoint = command_;
    decision.phase = phase_;
    return decision;
  }

  bool Accomplished() const override { return phase_ == "ended"; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }

  void Change(const mission::Flight& flight, const mission::PilotParameters&) override {
    if (const auto* changed = flight.As<AvoidFlight>()) flight_ = *changed;
  }

  void Draw(cv::Mat& bgr) const override {
    watch_.Draw(bgr);
    mission::DrawCommand(
        bgr, command_,
        {{flight_.speed_m_s, 0, kClimbLimit_m_s}, Radians(flight_.avoidance.hold.yaw_rate_limit_deg_s)});
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = {{std::string(phase_)},
                                              {fmt::format("mark {}", watch_.status())}};
    if (azimuth_) captions.push_back({fmt::format("bearing {:+.1f} deg", Degrees(*azimuth_))});
    captions.push_back({fmt::format("yaw {:+.1f} deg/s", Degrees(command_.yaw_rate))});
    return captions;
  }

 private:
  void Fly(const control::VehicleState& state, mission::Decision& decision) {
    azimuth_.reset();
    if (watch_.Measured()) {
      const Eigen::Vector3d ray_B = X_BC_.R * watch_.cone().axis;  // (6.23)
      azimuth_ = std::atan2(ray_B.y(), ray_B.x());                 // (6.24)
    }
    const control::HoldBearingStep step =
        control::HoldBearing(holding_, flight_.avoids ? azimuth_ : std::nullopt, flight_.avoidance.hold);
    holding_ = step.state;
    if (holding_.side) phase_ = "avoid";
    if (azimuth_) {
      const auto report = std::make_shared<AvoidReport>();
      report->encounter.azimuth = *azimuth_;
      if (step.status == control::HoldBearingStatus::kHolding)
        report->encounter.wanted = WrapAngle(*azimuth_ - step.error);
      decision.report = report;
    }
    const double sink = kHeightGain_per_s * (*down_m_ - state.p_NB.z());
    command_ = {{flight_.speed_m_s, 0, std::clamp(sink, -kClimbLimit_m_s, kClimbLimit_m_s)}, step.yaw_rate};
  }

  AvoidFlight flight_;
  Pose X_BC_;
  mission::BalloonObserver watch_;
  vision::FrozenImage frozen_;
  control::HoldBearingState holding_;
  std::optional<double> down_m_, azimuth_;
  std::string_view phase_ = "cruise";
  control::VelocitySetpoint command_;
};

}  // namespace

std::unique_ptr<mission::Mission> MakeSightMission(const AvoidFlight& flight,
                                                   const mission::MissionParts& parts) {
  return std::make_unique<SightMission>(flight, parts);
}

}  // namespace kestrel::scenarios
