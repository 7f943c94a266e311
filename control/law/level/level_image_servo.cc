// SPDX-License-Identifier: Apache-2.0
#include "control/law/level/level_image_servo.h"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

namespace kestrel::control {
namespace {

Eigen::Vector2d Centroid(std::span<const ImagePoint> points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const ImagePoint& p : points) sum += p.s;
  return sum / static_cast<double>(points.size());
}

}  // namespace

LevelImage LevelImageOf(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted) {
  assert(now.size() == wanted.size() && now.size() >= 2);
  const Eigen::Vector2d g = Centroid(now), g_wanted = Centroid(wanted);
  double a = 0, a_wanted = 0, along = 0, across = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Eigen::Vector2d p = now[i].s - g, r = wanted[i].s - g_wanted;
    a += p.squaredNorm(), a_wanted += r.squaredNorm();
    along += r.dot(p), across += r.x() * p.y() - r.y() * p.x();
  }
  return {std::sqrt(a_wanted / a) * g.homogeneous(), std::atan2(across, along)};
}

Eigen::Matrix<double, 3, 4> LevelImageInteraction(const Eigen::Vector3d& q, double Z_wanted) {
  Eigen::Matrix<double, 3, 4> L;
  L << -Eigen::Matrix3d::Identity() / Z_wanted, Eigen::Vector3d(q.y(), -q.x(), 0);
  return L;
}

LevelTwist LevelImageTwist(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                           double lambda_per_s) {
  const LevelImage has = LevelImageOf(now, wanted);
  double Z_wanted = 0;
  for (const ImagePoint& p : wanted) Z_wanted += p.Z / static_cast<double>(wanted.size());
  const Eigen::Vector3d e = has.q - Centroid(wanted).homogeneous();
  LevelTwist twist;
  twist.yaw_rate = lambda_per_s * has.angle;  // d(angle)/dt = -w_z
  const Eigen::Vector3d turned = LevelImageInteraction(has.q, Z_wanted).col(3) * twist.yaw_rate;
  twist.v = Z_wanted * (lambda_per_s * e + turned);  // L (v, w_z) = -lambda e
  return twist;
}

}  // namespace kestrel::control
