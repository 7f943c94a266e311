// SPDX-License-Identifier: Apache-2.0
#include "control/law/level/partitioned_servo.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {

PolygonImage PolygonImageOf(std::span<const ImagePoint> points) {
  assert(points.size() >= 3);
  double twice = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d &a = points[i].s, &b = points[(i + 1) % points.size()].s;
    twice += a.x() * b.y() - a.y() * b.x();
  }
  const Eigen::Vector2d across = points[points.size() / 2].s - points.front().s;
  return {std::sqrt(std::abs(twice) / 2), std::atan2(across.y(), across.x())};
}

LevelTwist PartitionedTwist(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                            double lambda_per_s) {
  assert(now.size() == wanted.size());
  const PolygonImage has = PolygonImageOf(now), wants = PolygonImageOf(wanted);
  double Z_wanted = 0;
  for (const ImagePoint& p : wanted) Z_wanted += p.Z / static_cast<double>(wanted.size());
  LevelTwist twist;
  // d(size)/dt = size / Z v_z and d(angle)/dt = -w_z, for a plane across the axis.
  twist.v.z() = lambda_per_s * Z_wanted * (wants.size - has.size) / wants.size;
  twist.yaw_rate = lambda_per_s * WrapAngle(has.angle - wants.angle);

  const auto points = static_cast<Eigen::Index>(now.size());
  Eigen::VectorXd e(2 * points);
  for (std::size_t i = 0; i < now.size(); ++i)
    e.segment<2>(2 * static_cast<Eigen::Index>(i)) = now[i].s - wanted[i].s;
  const Eigen::MatrixXd L = PointInteraction(now);
  // What the motion along and about the axis does to the points is not for the rest to undo: of the error it
  // takes its share, ds/dt = L_xy v_xy + L_z (v_z, w_z) = -lambda e.
  const Eigen::VectorXd rest = lambda_per_s * e + L.col(2) * twist.v.z() + L.col(5) * twist.yaw_rate;
  const Eigen::MatrixXd L_xy = L.leftCols<2>();
  twist.v.head<2>() = -(L_xy.transpose() * L_xy).ldlt().solve(L_xy.transpose() * rest);
  return twist;
}

}  // namespace kestrel::control
