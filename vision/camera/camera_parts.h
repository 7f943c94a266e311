// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>

#include "base/yaml/fields.h"
#include "geometry/tait_bryan.h"

// What the camera models share.
namespace kestrel::vision {

// A lens that shows all that its model can.
inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// Of a point in C, from the optical axis, rad, 0 to pi.
inline double AngleFromAxis(const Eigen::Vector3d& p_CQ) {
  return std::atan2(std::hypot(p_CQ.x(), p_CQ.y()), p_CQ.z());
}
inline bool WithinAngle(const Eigen::Vector3d& p_CQ, double max_angle_rad) {
  return max_angle_rad == kNoLimit || AngleFromAxis(p_CQ) <= max_angle_rad;
}

// The derivative of the unit ray by its pixel, from that of the pixel by a point at the ray's tip: the
// inverse in the plane across the ray, the only one in which a unit vector moves.
inline Eigen::Matrix<double, 3, 2> RayJacobian(const Eigen::Vector3d& ray,
                                               const Eigen::Matrix<double, 2, 3>& d_point) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = ray.unitOrthogonal();
  across.col(1) = ray.cross(across.col(0));
  const Eigen::Matrix2d d_across = d_point * across;
  return across * d_across.inverse();
}

// The keys that all cameras have; the model's own come between the two.
template <class Camera>
void ImageFields(FieldVisitor& v, Camera& c) {
  v(Required("width_px", "width of the image"), c.width_px, 16, 8192);
  v(Required("height_px", "height of the image"), c.height_px, 16, 8192);
  v(Required("fx_px", "horizontal focal length, as the camera model defines it"), c.fx, 1.0, 1e5);
  v(Required("fy_px", "vertical focal length, as the camera model defines it"), c.fy, 1.0, 1e5);
  v(Required("cx_px", "horizontal coordinate of the principal point; the centre of the first pixel is 0"),
    c.cx, -1e5, 1e5);
  v(Required("cy_px", "vertical coordinate of the principal point; the centre of the first pixel is 0"), c.cy,
    -1e5, 1e5);
}
template <class Camera>
void LensFields(FieldVisitor& v, Camera& c) {
  std::optional<double> field_deg;
  if (c.max_angle_rad != kNoLimit) field_deg = 2 * Degrees(c.max_angle_rad);
  v({"field_deg", "whole angle of view of the lens; not given: all that the camera model can show"},
    field_deg, 0.1, 360.0);
  c.max_angle_rad = field_deg ? Radians(*field_deg / 2) : kNoLimit;
}

}  // namespace kestrel::vision
