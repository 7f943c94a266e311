// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_parts.h"

namespace kestrel::vision {

// The extended unified model of Khomutenko, Garcia and Martinet (RA-L 2016): the point goes to an ellipsoid
// instead of the unified model's sphere, m = (x, y) / (alpha d + (1 - alpha) z) with d^2 = beta (x^2 + y^2) +
// z^2. Kalibr's eucm-none. With beta = 1 it is the unified model, whose xi is then alpha / (1 - alpha) and
// whose focal lengths are these over 1 - alpha.
struct ExtendedUnified {
  static constexpr const char* kName = "extended_unified";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double alpha = 0, beta = 1;
  double max_angle_rad = kNoLimit;  // of the lens, from its axis

  // The pixel of a point given in C, m, with its derivatives. Valid domain: MaxAngle(), where the picture
  // ends in infinity (alpha up to 1/2) or folds back; none outside it.
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

inline void Fields(FieldVisitor& v, ExtendedUnified& c) {
  ImageFields(v, c);
  v(Required("alpha", "puts the centre of projection alpha / (1 - alpha) behind that of the ellipsoid"),
    c.alpha, 0.0, 1.0);
  v(Required("beta",
             "squared ratio of the extent of the ellipsoid along the axis to that across it; 1: a sphere"),
    c.beta, 0.01, 100.0);
  LensFields(v, c);
}

}  // namespace kestrel::vision
