// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel::vision {

// OpenCV's rational distortion of a point m = (x, y) in the plane at unit distance, eight coefficients:
// m (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + (2 p1 x y + p2 (r^2 + 2 x^2),
// p1 (r^2 + 2 y^2) + 2 p2 x y).
//
// Like that without a denominator (radial_tangential.h) it is the gradient of a potential, and one to one on
// the disc in which that is convex: as far as the derivative of the radial part exceeds 6 r |p|.
struct RationalRadial {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;

  bool Holds(double radius) const;  // in the valid domain
  double MaxRadius() const;         // its limit; infinity: none
  double MaxDistorted() const;      // no point of the domain is distorted to further out than this

  // Without regard to the domain. d_parameters is by (k1, k2, p1, p2, k3, k4, k5, k6).
  Eigen::Vector2d Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* d_m = nullptr,
                          Eigen::Matrix<double, 2, 8>* d_parameters = nullptr) const;
  // The point of the domain that is distorted to this one, to 1e-12; none: there is none.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& distorted) const;
};

}  // namespace kestrel::vision
