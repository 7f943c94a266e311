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

// The field-of-view model of Devernay and Faugeras (Straight lines have to be straight, 2001): a point at the
// distance r from the axis, in the plane at unit distance, is seen at atan(2 r tan(w / 2)) / w focal lengths.
// Kalibr's pinhole-fov; the ATAN of PTAM.
struct Fov {
  static constexpr const char* kName = "fov";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double w = 1;                           // rad
  double max_angle_rad = kNoLimit;        // of the lens, from its axis

  // The pixel of a point given in C, m, with its derivatives. Valid domain: z > 0, within the angle of the
  // lens; none outside it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const {
    if (!(p_CQ.z() > 0) || !WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
    const Eigen::Vector2d m = p_CQ.head<2>() / p_CQ.z(), f(fx, fy);
    const double r = m.norm(), a = 2 * std::tan(w / 2), t = a * r, t2 = t * t;
    const double scale = t > 0 ? std::atan(t) / (w * r) : a / w;  // of m
    if (d_point) {
      // Of scale by r, over r: near the axis by its series, since the difference cancels there.
      const double slope = t < 0.01 ? a * a * a / w * (-2.0 / 3 + t2 * (4.0 / 5 - t2 * 6 / 7))
                                    : (a / (w * (1 + t2)) - scale) / (r * r);
      Eigen::Matrix<double, 2, 3> d_p;  // of m
      d_p << 1, 0, -m.x(), 0, 1, -m.y();
      *d_point =
          f.asDiagonal() * (scale * Eigen::Matrix2d::Identity() + slope * m * m.transpose()) * d_p / p_CQ.z();
    }
    if (d_parameters) {
      d_parameters->resize(2, 5);
      d_parameters->leftCols<4>() << scale * m.x(), 0, 1, 0, 0, scale * m.y(), 0, 1;
      d_parameters->col(4) = f.cwiseProduct(m) * ((1 + a * a / 4) / (1 + t2) - scale) / w;
    }
    return f.cwiseProduct(scale * m) + Eigen::Vector2d(cx, cy);
  }
  // Unit vector in C through a pixel, with its derivative; none where the lens shows nothing.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const {
    const Eigen::Vector2d distorted((uv.x() - cx) / fx, (uv.y() - cy) / fy);
    const double length = distorted.norm(), angle = w * length;
    if (!(angle < M_PI / 2)) return std::nullopt;
    const double a = 2 * std::tan(w / 2);
    // (distorted * r / length, 1) times cos(angle), which stays finite to the rim.
    const double side = length > 0 ? std::sin(angle) / (a * length) : w / a;
    const Eigen::Vector3d ray =
        Eigen::Vector3d(side * distorted.x(), side * distorted.y(), std::cos(angle)).normalized();
    if (!(ray.z() > 0) || !WithinAngle(ray, max_angle_rad)) return std::nullopt;
    if (d_pixel) {
      Eigen::Matrix<double, 2, 3> d_point;
      if (!Project(ray, &d_point)) return std::nullopt;
      *d_pixel = RayJacobian(ray, d_point);
    }
    return ray;
  }
  // How far from the axis the domain goes, rad.
  double MaxAngle() const { return std::min(max_angle_rad, M_PI / 2); }

  std::vector<std::string> ParameterNames() const { return {"fx", "fy", "cx", "cy", "w"}; }
  Eigen::VectorXd Parameters() const { return Eigen::Matrix<double, 5, 1>(fx, fy, cx, cy, w); }
  void SetParameters(const Eigen::VectorXd& all) {
    fx = all[0], fy = all[1], cx = all[2], cy = all[3], w = all[4];
  }
};

inline void Fields(FieldVisitor& v, Fov& c) {
  ImageFields(v, c);
  v(Required("w", "angle of the model, rad: the distorted radius is atan(2 r tan(w / 2)) / w"), c.w, 0.01,
    3.1);
  LensFields(v, c);
}

}  // namespace kestrel::vision
