// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_parts.h"

namespace kestrel::vision {

// The fisheye model of two unit spheres of Usenko, Demmel and Cremers (3DV 2018): the point goes to the first
// sphere, that to a second one whose centre is xi behind, and from there to a plane by a centre alpha / (1 -
// alpha) further behind. Kalibr's ds-none. With xi = 0 it is the unified model, whose xi is then alpha / (1 -
// alpha) and whose focal lengths are these over 1 - alpha.
struct DoubleSphere {
  static constexpr const char* kName = "double_sphere";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double xi = 0, alpha = 0;
  double max_angle_rad = kNoLimit;  // of the lens, from its axis

  // The pixel of a point given in C, m, with its derivatives. Valid domain: MaxAngle(); none outside it. The
  // domain's own limit is exact: the paper's w2 stops a degree or so before it.
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

inline void Fields(FieldVisitor& v, DoubleSphere& c) {
  ImageFields(v, c);
  v(Required("xi", "distance of the second unit sphere's centre behind that of the first"), c.xi, -0.99, 1.0);
  v(Required("alpha", "puts the centre of projection alpha / (1 - alpha) behind that of the second sphere"),
    c.alpha, 0.0, 1.0);
  LensFields(v, c);
}

}  // namespace kestrel::vision
