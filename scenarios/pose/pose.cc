// SPDX-License-Identifier: Apache-2.0
#include "scenarios/pose/pose.h"

#include "geometry/tait_bryan.h"
#include "scenarios/pose/pose_metrics.h"

namespace kestrel::scenarios {
namespace {

class PoseMission final : public mission::Mission {
 public:
  PoseMission(const PoseFlight& flight, mission::HelipadPilot pilot)
      : flight_(flight), pilot_(std::move(pilot)) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    if (!hold_)
      hold_ =
          control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    decision.phase = "hover";
    decision.setpoint = *hold_;
    return decision;
  }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions("hover on GPS"); }

 private:
  PoseFlight flight_;
  mission::HelipadPilot pilot_;
  std::optional<control::PositionSetpoint> hold_;
};

}  // namespace

mission::MissionType TypeOf(const PoseFlight&) {
  return {
      .name = "pose",
      .summary = "The aircraft hovers by its own sensors, and the vision only estimates where the pad is.",
      .looks_for_pad = true,
      .metrics = PoseMetrics(),
      .add_metrics = AddPoseMetrics,
      .common_metrics = {"fix_*", "longest_loss_s"}};
}

std::unique_ptr<mission::Mission> MakeMission(const PoseFlight& flight, const mission::MissionParts& parts) {
  return std::make_unique<PoseMission>(flight, mission::PilotOf(parts));
}

}  // namespace kestrel::scenarios
