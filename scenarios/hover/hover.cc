// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hover/hover.h"

#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

class HoverMission final : public Mission {
 public:
  HoverMission(const HoverFlight& flight, HelipadPilot pilot) : flight_(flight), pilot_(std::move(pilot)) {}

  Decision Step(const Frame& frame, const VehicleState& state) override {
    Decision decision = pilot_.See(frame, state);
    const Eigen::Vector3d goal_T(0, 0, -flight_.height_m);
    decision.goal_T = goal_T;
    decision.goal_yaw_TB = Radians(flight_.yaw_deg);
    if (state.landed) {
      phase_ = "take off";
      centred_ = false;
      decision.setpoint =
          PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    } else if (!pilot_.Knows()) {
      phase_ = "search";
      centred_ = false;
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      const Eigen::Vector3d& p_TB = pilot_.where().p_TB;
      centred_ = centred_ || p_TB.head<2>().norm() < flight_.centred_m;
      phase_ = centred_ ? "hover" : "centre";
      const double height = centred_ ? goal_T.z() : p_TB.z();
      decision.setpoint = pilot_.GoTo({0, 0, height}, Radians(flight_.yaw_deg));
    }
    decision.phase = phase_;
    return decision;
  }
  bool Accomplished() const override { return centred_; }
  TargetNeed Target() const override { return TargetNeed::kInSight; }
  VelocityLag MostLag() const override { return pilot_.MostLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr, phase_); }

 private:
  HoverFlight flight_;
  HelipadPilot pilot_;
  std::string_view phase_ = "search";
  bool centred_ = false;
};

}  // namespace

std::unique_ptr<Mission> MakeMission(const HoverFlight& flight, HelipadPilot pilot) {
  return std::make_unique<HoverMission>(flight, std::move(pilot));
}

}  // namespace kestrel
