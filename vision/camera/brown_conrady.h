// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_parts.h"
#include "vision/camera/radial_tangential.h"

namespace kestrel::vision {

// Pinhole camera with the distortion of Brown and Conrady: OpenCV's model with five coefficients, Kalibr's
// pinhole-radtan. Pixels as everywhere: the centre of the first is (0, 0).
struct BrownConrady {
  static constexpr const char* kName = "brown_conrady";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;          // px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;  // in OpenCV's order
  double max_angle_rad = kNoLimit;                // of the lens, from its axis

  RadialTangential Distortion() const { return {k1, k2, p1, p2, k3}; }

  // The pixel of a point given in C, m, with its derivatives. Valid domain: z > 0, within the angle of the
  // lens and the radius to which the distortion is one to one (radial_tangential.h); none outside it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const;
  // Unit vector in C through a pixel, with its derivative; none where the lens shows nothing.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const;
  double MaxAngle() const;  // how far from the axis the domain goes, rad

  std::vector<std::string> ParameterNames() const;
  Eigen::VectorXd Parameters() const;
  void SetParameters(const Eigen::VectorXd& all);
};

inline void Fields(FieldVisitor& v, BrownConrady& c) {
  ImageFields(v, c);
  v({"k1", "radial distortion as in OpenCV, coefficient of r^2"}, c.k1, -100.0, 100.0);
  v({"k2", "radial distortion as in OpenCV, coefficient of r^4"}, c.k2, -1e3, 1e3);
  v({"p1", "first coefficient of tangential distortion, as in OpenCV"}, c.p1, -1.0, 1.0);
  v({"p2", "second coefficient of tangential distortion, as in OpenCV"}, c.p2, -1.0, 1.0);
  v({"k3", "radial distortion as in OpenCV, coefficient of r^6"}, c.k3, -1e4, 1e4);
  LensFields(v, c);
}

}  // namespace kestrel::vision
