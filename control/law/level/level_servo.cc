// SPDX-License-Identifier: Apache-2.0
#include "control/law/level/level_servo.h"

#include <algorithm>
#include <cassert>

#include "control/law/level_camera.h"

namespace kestrel::control {
namespace {

// Points of any kind: their error, whether they lie where the matrix holds, and the matrix by four columns.
template <int kSize, class Point, class Distance>
ServoStep Solve(std::span<const Point> now, std::span<const Point> wanted, InteractionChoice choice,
                const Eigen::Vector3d& down_V, double lambda_per_s, const auto& interaction,
                Distance distance) {
  assert(now.size() == wanted.size());
  const auto behind = [&](const Point& p) { return !(p.*distance > 0); };
  if ((choice != InteractionChoice::kDesired && std::ranges::any_of(now, behind)) ||
      (choice != InteractionChoice::kCurrent && std::ranges::any_of(wanted, behind))) {
    ServoStep step;
    step.state = ServoState::kDepthNotPositive;
    step.velocity = Eigen::VectorXd::Zero(4);
    return step;
  }
  Eigen::VectorXd e(kSize * static_cast<Eigen::Index>(now.size()));
  for (std::size_t i = 0; i < now.size(); ++i)
    e.segment<kSize>(kSize * static_cast<Eigen::Index>(i)) = now[i].s - wanted[i].s;
  const Eigen::MatrixXd L = Choose(choice, interaction(now), interaction(wanted));
  return ServoVelocity(LevelInteraction(L, down_V), e, lambda_per_s);
}

}  // namespace

LevelTwist LevelTwistOf(const ServoStep& step) {
  assert(step.velocity.size() == 4);
  return {step.velocity.head<3>(), step.velocity[3]};
}

LevelTwist LevelTwistOf(const Twist& twist_V, const Eigen::Vector3d& down_V) {
  return {twist_V.v, twist_V.w.dot(down_V)};
}

ServoStep LevelPointServo(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                          InteractionChoice choice, const Eigen::Vector3d& down_V, double lambda_per_s) {
  return Solve<2>(
      now, wanted, choice, down_V, lambda_per_s,
      [](std::span<const ImagePoint> points) { return PointInteraction(points); }, &ImagePoint::Z);
}

ServoStep LevelBearingServo(std::span<const BearingPoint> now, std::span<const BearingPoint> wanted,
                            InteractionChoice choice, const Eigen::Vector3d& down_V, double lambda_per_s) {
  return Solve<3>(
      now, wanted, choice, down_V, lambda_per_s,
      [](std::span<const BearingPoint> points) { return BearingInteraction(points); }, &BearingPoint::L);
}

}  // namespace kestrel::control
