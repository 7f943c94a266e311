// SPDX-License-Identifier: Apache-2.0
#include "control/law/point_servo.h"

#include <algorithm>
#include <cassert>

namespace kestrel::control {

Eigen::Matrix<double, 2, 6> PointInteraction(const Eigen::Vector2d& s, double Z) {
  const double x = s.x(), y = s.y();
  Eigen::Matrix<double, 2, 6> L;
  L << -1 / Z, 0, x / Z, x * y, -(x * x + 1), y,  // eq. (5.5)
      0, -1 / Z, y / Z, y * y + 1, -x * y, -x;
  return L;
}

Eigen::MatrixXd PointInteraction(std::span<const ImagePoint> points) {
  Eigen::MatrixXd L(2 * points.size(), 6);
  for (std::size_t i = 0; i < points.size(); ++i) {
    L.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = PointInteraction(points[i].s, points[i].Z);
  }
  return L;
}

ServoStep PointServo(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                     InteractionChoice choice, double lambda_per_s, const Inversion& inversion) {
  assert(now.size() == wanted.size());
  Eigen::VectorXd e(2 * now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    e.segment<2>(static_cast<Eigen::Index>(2 * i)) = now[i].s - wanted[i].s;
  }
  const auto behind = [](const ImagePoint& p) { return p.Z <= 0; };
  if ((choice != InteractionChoice::kDesired && std::ranges::any_of(now, behind)) ||
      (choice != InteractionChoice::kCurrent && std::ranges::any_of(wanted, behind))) {
    ServoStep step;
    step.state = ServoState::kDepthNotPositive;
    step.velocity = Eigen::VectorXd::Zero(6);
    return step;
  }
  return ServoVelocity(Choose(choice, PointInteraction(now), PointInteraction(wanted)), e, lambda_per_s,
                       inversion);
}

}  // namespace kestrel::control
