// SPDX-License-Identifier: Apache-2.0
#include "scenarios/pose/pose.h"

#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

class PoseMission final : public Mission {
 public:
  PoseMission(const PoseFlight& flight, HelipadPilot pilot) : flight_(flight), pilot_(std::move(pilot)) {}

  Decision Step(const Frame& frame, const VehicleState& state) override {
    Decision decision = pilot_.See(frame, state);
    if (!hold_)
      hold_ = PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    decision.phase = "hover";
    decision.setpoint = *hold_;
    return decision;
  }
  TargetNeed Target() const override { return TargetNeed::kInSight; }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr, "hover on GPS"); }

 private:
  PoseFlight flight_;
  HelipadPilot pilot_;
  std::optional<PositionSetpoint> hold_;
};

}  // namespace

std::unique_ptr<Mission> MakeMission(const PoseFlight& flight, HelipadPilot pilot) {
  return std::make_unique<PoseMission>(flight, std::move(pilot));
}

}  // namespace kestrel
