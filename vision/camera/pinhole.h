// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_parts.h"

namespace kestrel::vision {

// Pinhole camera without distortion, thesis 3.16 and 5.1. Pixels: the centre of the first pixel is (0, 0), u
// to the right, v down.
struct Pinhole {
  static constexpr const char* kName = "pinhole";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double max_angle_rad = kNoLimit;        // of the lens, from its axis

  // The pixel of a point given in C, m, which may lie off the image, with its derivatives by the point and by
  // the parameters. Valid domain: z > 0, within the angle of the lens; none outside it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const {
    if (!(p_CQ.z() > 0) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
    const double x = p_CQ.x() / p_CQ.z(), y = p_CQ.y() / p_CQ.z();
    if (d_point) *d_point << fx / p_CQ.z(), 0, -fx * x / p_CQ.z(), 0, fy / p_CQ.z(), -fy * y / p_CQ.z();
    if (d_parameters) {
      d_parameters->resize(2, 4);
      *d_parameters << x, 0, 1, 0, 0, y, 0, 1;
    }
    return Eigen::Vector2d(fx * p_CQ.x() / p_CQ.z() + cx, fy * p_CQ.y() / p_CQ.z() + cy);
  }
  // Unit vector in C through a pixel, with its derivative; none where the lens shows nothing.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const {
    if (!uv.allFinite()) return std::nullopt;
    const Eigen::Vector3d ray = Eigen::Vector3d((uv.x() - cx) / fx, (uv.y() - cy) / fy, 1).normalized();
    if (!(ray.z() > 0) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
    if (d_pixel) {
      Eigen::Matrix<double, 2, 3> d_point;
      Project(ray, &d_point);
      *d_pixel = RayJacobian(ray, d_point);
    }
    return ray;
  }
  // How far from the axis the domain goes, rad.
  double MaxAngle() const { return std::min(max_angle_rad, M_PI / 2); }

  std::vector<std::string> ParameterNames() const { return {"fx", "fy", "cx", "cy"}; }
  Eigen::VectorXd Parameters() const { return Eigen::Vector4d(fx, fy, cx, cy); }
  void SetParameters(const Eigen::VectorXd& all) { fx = all[0], fy = all[1], cx = all[2], cy = all[3]; }

  // The calibration matrix K of thesis 3.16.
  Eigen::Matrix3d K() const {
    Eigen::Matrix3d k;
    k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
    return k;
  }
};

inline void Fields(FieldVisitor& v, Pinhole& c) {
  ImageFields(v, c);
  LensFields(v, c);
}

}  // namespace kestrel::vision
