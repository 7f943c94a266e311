// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/distortion/rational_radial.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/camera/distortion/one_to_one.h"
#include "vision/camera/distortion/polynomial.h"

namespace kestrel::vision {
namespace {

// In s = r^2.
std::array<double, 4> Numerator(const RationalRadial& d) { return {1, d.k1, d.k2, d.k3}; }
std::array<double, 4> Denominator(const RationalRadial& d) { return {1, d.k4, d.k5, d.k6}; }

// The slope of the radial part times the square of the denominator, less 6 r |p| times the same, as a
// polynomial of the radius: N D + 2 s (N' D - N D') - 6 r |p| D^2.
std::array<double, 14> ScaledMinSlope(const RationalRadial& d) {
  const auto N = Numerator(d), D = Denominator(d);
  const double p = 6 * std::hypot(d.p1, d.p2);
  std::array<double, 14> slope{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      slope[2 * (i + j)] += N[i] * D[j] * (1 + 2 * (static_cast<double>(i) - static_cast<double>(j)));
      slope[2 * (i + j) + 1] -= p * D[i] * D[j];
    }
  }
  return slope;
}

struct Value {
  double of = 0, slope = 0;  // at s, and its derivative
};
Value At(const std::array<double, 4>& c, double s) {
  return {c[0] + s * (c[1] + s * (c[2] + s * c[3])), c[1] + s * (2 * c[2] + s * 3 * c[3])};
}

}  // namespace

bool RationalRadial::Holds(double radius) const {
  return PositiveUpTo(Denominator(*this), radius * radius) && PositiveUpTo(ScaledMinSlope(*this), radius);
}

double RationalRadial::MaxRadius() const {
  return std::min(std::sqrt(FirstZero(Denominator(*this))), FirstZero(ScaledMinSlope(*this)));
}

double RationalRadial::MaxDistorted() const {
  const double r = MaxRadius(), s = r * r;
  return r * At(Numerator(*this), s).of / At(Denominator(*this), s).of + 3 * s * std::hypot(p1, p2);
}

Eigen::Vector2d RationalRadial::Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* d_m,
                                        Eigen::Matrix<double, 2, 8>* d_parameters) const {
  const double x = m.x(), y = m.y(), s = m.squaredNorm();
  const Value N = At(Numerator(*this), s), D = At(Denominator(*this), s);
  const double radial = N.of / D.of;
  if (d_m) {
    const double slope = 2 * (N.slope - radial * D.slope) / D.of;  // of radial, by r, over r
    const double across = slope * x * y + 2 * (p1 * x + p2 * y);
    *d_m << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, across,  //
        across, radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  if (d_parameters) {
    const double above[] = {s / D.of, s * s / D.of, s * s * s / D.of};
    d_parameters->col(0) = above[0] * m;
    d_parameters->col(1) = above[1] * m;
    d_parameters->col(2) << 2 * x * y, s + 2 * y * y;
    d_parameters->col(3) << s + 2 * x * x, 2 * x * y;
    d_parameters->col(4) = above[2] * m;
    for (int i = 0; i < 3; ++i) d_parameters->col(5 + i) = -radial * above[i] * m;
  }
  return {radial * x + 2 * p1 * x * y + p2 * (s + 2 * x * x),
          radial * y + p1 * (s + 2 * y * y) + 2 * p2 * x * y};
}

std::optional<Eigen::Vector2d> RationalRadial::Undistort(const Eigen::Vector2d& distorted) const {
  return UndistortOneToOne(*this, distorted);
}

}  // namespace kestrel::vision
