// SPDX-License-Identifier: Apache-2.0
#include "control/law/bearing_servo.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/pose.h"

namespace kestrel::control {

SpherePoint SpherePointOf(const Eigen::Vector3d& s) {
  return {std::atan2(std::hypot(s.x(), s.y()), s.z()), std::atan2(s.y(), s.x())};  // eq. (6.24)
}

Eigen::Vector3d BearingOf(const SpherePoint& point) {
  const double across = std::sin(point.colatitude);
  return {across * std::cos(point.azimuth), across * std::sin(point.azimuth), std::cos(point.colatitude)};
}

std::optional<Eigen::Matrix<double, 2, 6>> SpherePointInteraction(const SpherePoint& point, double L) {
  const double st = std::sin(point.colatitude), ct = std::cos(point.colatitude);
  const double sp = std::sin(point.azimuth), cp = std::cos(point.azimuth);
  // an azimuth that turns 1e9 times as fast as the bearing says nothing any more
  if (!(std::abs(st) > 1e-9)) return std::nullopt;
  Eigen::Matrix<double, 2, 6> J;
  J << -ct * cp / L, -ct * sp / L, st / L, sp, -cp, 0,  // eq. (6.25)
      sp / (L * st), -cp / (L * st), 0, ct * cp / st, ct * sp / st, -1;
  return J;
}

Eigen::Matrix<double, 3, 6> BearingInteraction(const Eigen::Vector3d& s, double L) {
  Eigen::Matrix<double, 3, 6> J;
  J << (s * s.transpose() - Eigen::Matrix3d::Identity()) / L, Skew(s);
  return J;
}

Eigen::MatrixXd BearingInteraction(std::span<const BearingPoint> points) {
  Eigen::MatrixXd J(3 * points.size(), 6);
  for (std::size_t i = 0; i < points.size(); ++i) {
    J.middleRows<3>(static_cast<Eigen::Index>(3 * i)) = BearingInteraction(points[i].s, points[i].L);
  }
  return J;
}

ServoStep BearingServo(std::span<const BearingPoint> now, std::span<const BearingPoint> wanted,
                       InteractionChoice choice, double lambda_per_s, const Inversion& inversion) {
  assert(now.size() == wanted.size());
  Eigen::VectorXd e(3 * now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    e.segment<3>(static_cast<Eigen::Index>(3 * i)) = now[i].s - wanted[i].s;
  }
  const auto at_camera = [](const BearingPoint& p) { return p.L <= 0; };
  if ((choice != InteractionChoice::kDesired && std::ranges::any_of(now, at_camera)) ||
      (choice != InteractionChoice::kCurrent && std::ranges::any_of(wanted, at_camera))) {
    ServoStep step;
    step.state = ServoState::kDepthNotPositive;
    step.velocity = Eigen::VectorXd::Zero(6);
    return step;
  }
  return ServoVelocity(Choose(choice, BearingInteraction(now), BearingInteraction(wanted)), e, lambda_per_s,
                       inversion);
}

}  // namespace kestrel::control
