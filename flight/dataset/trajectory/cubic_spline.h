// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace kestrel::flight {

// The natural cubic spline through points: twice continuously differentiable, and without curvature at its
// ends. (C. de Boor, "A Practical Guide to Splines", 1978, chapter IV.)
class CubicSpline {
 public:
  CubicSpline() = default;
  // At least two knots, in rising order, and as many points.
  CubicSpline(std::vector<double> knots, std::vector<Eigen::Vector3d> points);

  struct Point {
    Eigen::Vector3d value, first,
        second;  // and its derivatives by the parameter
  };
  Point At(double t) const;  // beyond the ends: there

 private:
  std::vector<double> knots_;
  std::vector<Eigen::Vector3d> points_, curvatures_;
};

}  // namespace kestrel::flight
