// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel::vision {

// The lens distortion of Brown and Conrady, of a point m = (x, y) in the plane at unit distance, in OpenCV's
// notation: m (1 + k1 r^2 + k2 r^4 + k3 r^6) + (2 p1 x y + p2 (r^2 + 2 x^2), p1 (r^2 + 2 y^2) + 2 p2 x y).
//
// It is the gradient of a potential, m^2 / 2 + ... + (p1 y + p2 x) r^2, hence one to one on any disc in which
// that is convex: up to the radius at which 1 + 3 k1 r^2 + 5 k2 r^4 + 7 k3 r^6 = 6 r |p| for the first time.
// Beyond it the picture folds back. Without tangential part this is where the radial polynomial stops
// growing.
struct RadialTangential {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool IsNone() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
  bool Holds(double radius) const;  // in the valid domain
  double MaxRadius() const;         // its limit; infinity: none

  // Without regard to the domain. d_parameters is by (k1, k2, p1, p2, k3).
  Eigen::Vector2d Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* d_m = nullptr,
                          Eigen::Matrix<double, 2, 5>* d_parameters = nullptr) const;
  // The point of the domain that is distorted to this one, to 1e-12; none: there is none.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& distorted) const;
};

}  // namespace kestrel::vision
