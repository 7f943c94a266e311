// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_parts.h"

namespace kestrel::vision {

// The fisheye of Kannala and Brandt: at the angle theta from the axis, a point lies
// theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) focal lengths from the centre. Kalibr's
// pinhole-equi and OpenCV's fisheye, but not stopped at 90 degrees as they are.
struct KannalaBrandt {
  static constexpr const char* kName = "kannala_brandt";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
  double max_angle_rad = kNoLimit;  // of the lens, from its axis

  // The pixel of a point given in C, m, with its derivatives. Valid domain: less than 180 degrees from the
  // axis, within the angle of the lens and that to which the polynomial grows; none outside it.
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

 private:
  bool Holds(double theta) const;
  std::optional<double> Theta(double distorted) const;
};

inline void Fields(FieldVisitor& v, KannalaBrandt& c) {
  ImageFields(v, c);
  v({"k1", "coefficient of theta^3 in the distorted angle, theta being the angle from the axis in rad"}, c.k1,
    -100.0, 100.0);
  v({"k2", "coefficient of theta^5 in the distorted angle, theta being the angle from the axis in rad"}, c.k2,
    -100.0, 100.0);
  v({"k3", "coefficient of theta^7 in the distorted angle, theta being the angle from the axis in rad"}, c.k3,
    -100.0, 100.0);
  v({"k4", "coefficient of theta^9 in the distorted angle, theta being the angle from the axis in rad"}, c.k4,
    -100.0, 100.0);
  LensFields(v, c);
}

}  // namespace kestrel::vision
