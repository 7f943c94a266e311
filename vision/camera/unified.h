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

// The unified model on the sphere, for every central catadioptric camera and most fisheyes, thesis 6.2 to
// 6.5, in Mei's form: the point goes to the unit sphere, and from there by a centre that is xi behind the
// sphere's, m = (x, y) / (z + xi r), to a plane with distortion and generalised focal lengths. xi is 0 for a
// pinhole, 1 for a parabolic mirror, between them for hyperbolic and elliptical ones; lenses have any. The
// same as Kalibr's omni-radtan and OpenCV's omnidir. vision/camera/mirror.h relates it to Barreto's (xi, psi)
// and Geyer's (l, m). z of C points out of the mirror, to the real camera; the image is the one that has been
// flipped back, since a mirror shows it reversed.
struct Unified {
  static constexpr const char* kName = "unified";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px; fx, fy are the generalised focal lengths gamma
  double xi = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // in OpenCV's order
  double skew = 0;                        // px
  double max_angle_rad = kNoLimit;        // of the lens, from its axis

  RadialTangential Distortion() const { return {k1, k2, p1, p2}; }

  // The pixel of a point given in C, m, with its derivatives. Valid domain: the angle theta from the axis
  // with cos(theta) > -xi (up to xi = 1; there the picture ends in infinity) or cos(theta) > -1 / xi (beyond;
  // there it folds back), within the angle of the lens and where the distortion is one to one
  // (radial_tangential.h); none outside it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const;
  // Unit vector in C through a pixel, with its derivative; none where the lens shows nothing. Eq. (6.5).
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const;
  double MaxAngle() const;  // how far from the axis the domain goes, rad

  std::vector<std::string> ParameterNames() const;
  Eigen::VectorXd Parameters() const;
  void SetParameters(const Eigen::VectorXd& all);
};

inline void Fields(FieldVisitor& v, Unified& c) {
  ImageFields(v, c);
  v(Required("xi",
             "distance of the centre of projection behind the sphere's; 0: pinhole, 1: parabolic mirror"),
    c.xi, 0.0, 20.0);
  v({"k1", "radial distortion as in OpenCV, coefficient of r^2"}, c.k1, -100.0, 100.0);
  v({"k2", "radial distortion as in OpenCV, coefficient of r^4"}, c.k2, -1e3, 1e3);
  v({"p1", "first coefficient of tangential distortion, as in OpenCV"}, c.p1, -1.0, 1.0);
  v({"p2", "second coefficient of tangential distortion, as in OpenCV"}, c.p2, -1.0, 1.0);
  v({"skew_px", "skew of the pixels: u = fx x + skew y + cx, as in OpenCV"}, c.skew, -1e3, 1e3);
  LensFields(v, c);
}

}  // namespace kestrel::vision
