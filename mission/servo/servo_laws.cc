// SPDX-License-Identifier: Apache-2.0
#include "mission/servo/servo_laws.h"

#include <Eigen/Geometry>
#include <cassert>

#include "control/law/level/hybrid_servo.h"
#include "control/law/level/level_image_servo.h"
#include "control/law/level/partitioned_servo.h"
#include "control/law/pbvs.h"

namespace kestrel::mission {
namespace {

using control::InteractionChoice;

ServoAnswer OfStep(const control::ServoStep& step) {
  return {control::LevelTwistOf(step), step.state, step.conditioning, step.reach};
}

std::vector<control::BearingPoint> Bearings(const std::vector<control::ImagePoint>& points) {
  std::vector<control::BearingPoint> bearings;
  for (const control::ImagePoint& p : points) {
    const Eigen::Vector3d ray = p.s.homogeneous();
    bearings.push_back({ray.normalized(), p.Z * ray.norm()});
  }
  return bearings;
}

bool AllBefore(const std::vector<control::ImagePoint>& points) {
  for (const control::ImagePoint& p : points)
    if (!(p.Z > 0)) return false;
  return true;
}

}  // namespace

const std::vector<std::string>& ServoLawNames() {
  static const std::vector<std::string> kNames = {
      "points_current", "points_desired", "points_mean", "points_adaptive", "bearings",
      "hybrid",         "partitioned",    "level_image", "pose_target",     "pose"};
  return kNames;
}

ServoAnswer AnswerOf(const std::string& law, const ServoView& view, double lambda_per_s) {
  const auto points = [&](const std::vector<control::ImagePoint>& corners, InteractionChoice choice) {
    return OfStep(control::LevelPointServo(corners, view.corners_wanted, choice, view.down_V, lambda_per_s));
  };
  if (law == "points_current") return points(view.corners, InteractionChoice::kCurrent);
  if (law == "points_desired") return points(view.corners, InteractionChoice::kDesired);
  if (law == "points_mean") return points(view.corners, InteractionChoice::kMean);
  if (!AllBefore(view.corners) || !AllBefore(view.corners_wanted))
    return {{}, control::ServoState::kDepthNotPositive, 0, 0};
  if (law == "points_adaptive") {
    std::vector<control::ImagePoint> corners = view.corners;
    for (control::ImagePoint& p : corners) p.Z = view.plane_depth_m.value_or(p.Z);
    return points(corners, InteractionChoice::kCurrent);
  }
  if (law == "bearings")
    return OfStep(control::LevelBearingServo(Bearings(view.corners), Bearings(view.corners_wanted),
                                             InteractionChoice::kCurrent, view.down_V, lambda_per_s));
  const Pose X_DV = view.X_DT * view.X_VT.Inverse();
  if (law == "hybrid") {
    // V and D are both level: the rotation between them is a yaw, but for errors.
    const Eigen::Vector3d yaw = view.down_V * view.down_V.dot(LogRotation(X_DV.R));
    return {control::LevelTwistOf(control::HybridTwist(view.centre, view.centre_wanted, yaw, lambda_per_s),
                                  view.down_V)};
  }
  if (law == "partitioned")
    return {control::PartitionedTwist(view.corners, view.corners_wanted, lambda_per_s)};
  if (law == "level_image")
    return {control::LevelImageTwist(view.corners, view.corners_wanted, lambda_per_s)};
  if (law == "pose_target")
    return {control::LevelTwistOf(control::PbvsTargetTwist(view.X_VT, view.X_DT, lambda_per_s), view.down_V)};
  assert(law == "pose");
  return {control::LevelTwistOf(control::PbvsTwist(X_DV, lambda_per_s), view.down_V)};
}

}  // namespace kestrel::mission
