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
#include "vision/camera/distortion/rational_radial.h"

namespace kestrel::vision {

// Pinhole camera with the rational distortion of OpenCV (eight coefficients) and ROS (rational_polynomial):
// brown_conrady, whose radial part is divided by 1 + k4 r^2 + k5 r^4 + k6 r^6.
struct Rational {
  static constexpr const char* kName = "rational";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  RationalRadial distortion = {};
  double max_angle_rad = kNoLimit;  // of the lens, from its axis

  // The pixel of a point given in C, m, with its derivatives. Valid domain: z > 0, within the angle of the
  // lens and the radius to which the distortion is one to one (rational_radial.h); none outside it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const {
    if (!(p_CQ.z() > 0) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
    const Eigen::Vector2d m = p_CQ.head<2>() / p_CQ.z(), f(fx, fy);
    if (!distortion.Holds(m.norm())) return std::nullopt;
    Eigen::Matrix2d d_m;
    Eigen::Matrix<double, 2, 8> d_distortion;
    const Eigen::Vector2d distorted = distortion.Distort(m, &d_m, d_parameters ? &d_distortion : nullptr);
    if (d_point) {
      Eigen::Matrix<double, 2, 3> d_p;  // of m
      d_p << 1, 0, -m.x(), 0, 1, -m.y();
      *d_point = f.asDiagonal() * d_m * d_p / p_CQ.z();
    }
    if (d_parameters) {
      d_parameters->resize(2, 12);
      d_parameters->leftCols<4>() << distorted.x(), 0, 1, 0, 0, distorted.y(), 0, 1;
      d_parameters->rightCols<8>() = f.asDiagonal() * d_distortion;
    }
    return f.cwiseProduct(distorted) + Eigen::Vector2d(cx, cy);
  }
  // Unit vector in C through a pixel, with its derivative; none where the lens shows nothing.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const {
    const auto m = distortion.Undistort({(uv.x() - cx) / fx, (uv.y() - cy) / fy});
    if (!m) return std::nullopt;
    const Eigen::Vector3d ray = m->homogeneous().normalized();
    if (!(ray.z() > 0) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
    if (d_pixel) {
      Eigen::Matrix<double, 2, 3> d_point;
      if (!Project(ray, &d_point)) return std::nullopt;
      *d_pixel = RayJacobian(ray, d_point);
    }
    return ray;
  }
  // How far from the axis the domain goes, rad.
  double MaxAngle() const { return std::min(max_angle_rad, std::atan(distortion.MaxRadius())); }

  std::vector<std::string> ParameterNames() const {
    return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  }
  Eigen::VectorXd Parameters() const {
    const RationalRadial& d = distortion;
    return Eigen::Matrix<double, 12, 1>(fx, fy, cx, cy, d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6);
  }
  void SetParameters(const Eigen::VectorXd& all) {
    fx = all[0], fy = all[1], cx = all[2], cy = all[3];
    distortion = {all[4], all[5], all[6], all[7], all[8], all[9], all[10], all[11]};
  }
};

inline void Fields(FieldVisitor& v, Rational& c) {
  RationalRadial& d = c.distortion;
  ImageFields(v, c);
  v({"k1", "radial distortion as in OpenCV, coefficient of r^2 above"}, d.k1, -1e3, 1e3);
  v({"k2", "radial distortion as in OpenCV, coefficient of r^4 above"}, d.k2, -1e4, 1e4);
  v({"p1", "first coefficient of tangential distortion, as in OpenCV"}, d.p1, -1.0, 1.0);
  v({"p2", "second coefficient of tangential distortion, as in OpenCV"}, d.p2, -1.0, 1.0);
  v({"k3", "radial distortion as in OpenCV, coefficient of r^6 above"}, d.k3, -1e4, 1e4);
  v({"k4", "radial distortion as in OpenCV, coefficient of r^2 below"}, d.k4, -1e3, 1e3);
  v({"k5", "radial distortion as in OpenCV, coefficient of r^4 below"}, d.k5, -1e4, 1e4);
  v({"k6", "radial distortion as in OpenCV, coefficient of r^6 below"}, d.k6, -1e4, 1e4);
  LensFields(v, c);
}

}  // namespace kestrel::vision
