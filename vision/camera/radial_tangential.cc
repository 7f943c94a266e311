// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/radial_tangential.h"

#include <array>
#include <cmath>

#include "vision/camera/distortion/one_to_one.h"
#include "vision/camera/distortion/polynomial.h"

namespace kestrel::vision {
namespace {

// The least eigenvalue of the Jacobian over all directions, as a polynomial of the radius.
std::array<double, 7> MinSlope(const RadialTangential& d) {
  return {1, -6 * std::hypot(d.p1, d.p2), 3 * d.k1, 0, 5 * d.k2, 0, 7 * d.k3};
}

}  // namespace

bool RadialTangential::Holds(double radius) const {
  return IsNone() ? std::isfinite(radius) : PositiveUpTo(MinSlope(*this), radius);
}

double RadialTangential::MaxRadius() const { return FirstZero(MinSlope(*this)); }

Eigen::Vector2d RadialTangential::Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* d_m,
                                          Eigen::Matrix<double, 2, 5>* d_parameters) const {
  const double x = m.x(), y = m.y(), r2 = m.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (d_m) {
    const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // of radial, by r, over r
    const double across = slope * x * y + 2 * (p1 * x + p2 * y);
    *d_m << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, across,  //
        across, radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  if (d_parameters) {
    d_parameters->col(0) = r2 * m;
    d_parameters->col(1) = r2 * r2 * m;
    d_parameters->col(2) << 2 * x * y, r2 + 2 * y * y;
    d_parameters->col(3) << r2 + 2 * x * x, 2 * x * y;
    d_parameters->col(4) = r2 * r2 * r2 * m;
  }
  return {radial * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          radial * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

std::optional<Eigen::Vector2d> RadialTangential::Undistort(const Eigen::Vector2d& distorted) const {
  struct Bounded : RadialTangential {
    double MaxDistorted() const {
      const double r = MaxRadius(), r2 = r * r;
      return r * (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) + 3 * r2 * std::hypot(p1, p2);
    }
  };
  if (IsNone() && distorted.allFinite()) return distorted;
  return UndistortOneToOne(Bounded{*this}, distorted);
}

}  // namespace kestrel::vision
