// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hover/hover.h"

#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

class HoverMission final : public mission::Mission {
 public:
  HoverMission(const HoverFlight& flight, std::unique_ptr<mission::Pilot> pilot)
      : flight_(flight), own_pilot_(std::move(pilot)), pilot_(*own_pilot_) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    const Eigen::Vector3d goal_T(0, 0, -flight_.height_m);
    decision.goal_T = goal_T;
    decision.goal_yaw_TB = Radians(flight_.yaw_deg);
    if (state.landed) {
      phase_ = "take off";
      centred_ = false;
      decision.setpoint =
          control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    } else if (!pilot_.HasEstimate()) {
      phase_ = "search";
      centred_ = false;
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      const Eigen::Vector3d& p_TB = pilot_.where().p_TB;
      centred_ = centred_ || p_TB.head<2>().norm() < flight_.centred_m;
      phase_ = centred_ ? "hover" : "centre";
      const double height = centred_ ? goal_T.z() : pilot_.Ahead_T().z();
      decision.setpoint = pilot_.GoTo({0, 0, height}, Radians(flight_.yaw_deg));
    }
    decision.phase = phase_;
    return decision;
  }
  void Change(const mission::Flight& flight, const mission::PilotParameters& pilot) override {
    if (const auto* changed = flight.As<HoverFlight>()) flight_ = *changed;
    pilot_.ChangeServo(pilot.servo);
  }
  bool Accomplished() const override { return centred_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions(phase_); }
  cv::Mat ProductImage() const override { return pilot_.ProductImage(); }

 private:
  HoverFlight flight_;
  std::unique_ptr<mission::Pilot> own_pilot_;
  mission::Pilot& pilot_;
  std::string_view phase_ = "search";
  bool centred_ = false;
};

}  // namespace

mission::MissionType TypeOf(const HoverFlight&) {
  return {.name = "hover",
          .summary = "Centres over the pad, goes to a height and stays there.",
          .looks_for_pad = true,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "hold_*"},
          .changeable = {"flight.*", "pilot.servo.*"}};
}

std::unique_ptr<mission::Mission> MakeHover(const HoverFlight& flight,
                                            std::unique_ptr<mission::Pilot> pilot) {
  return std::make_unique<HoverMission>(flight, std::move(pilot));
}

std::unique_ptr<mission::Mission> MakeMission(const HoverFlight& flight, const mission::MissionParts& parts) {
  return MakeHover(flight, std::make_unique<mission::HelipadPilot>(mission::PilotOf(parts)));
}

}  // namespace kestrel::scenarios
