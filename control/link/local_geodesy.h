// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace kestrel::control {

// North and east of a place on the WGS 84 ellipsoid, m, by its two radii of curvature there: the plane that
// touches it. Within a kilometre the error is below 0.3 m, by the Earth's bending and the meridians'
// convergence (up to 60 degrees of latitude). Latitude and longitude in rad.
class LocalPlane {
 public:
  LocalPlane() : LocalPlane(0, 0) {}
  // height: of the plane above the ellipsoid, m.
  LocalPlane(double latitude, double longitude, double height = 0)
      : latitude_(latitude), longitude_(longitude) {
    constexpr double a = 6378137, e2 = 6.69437999014e-3;
    const double s = std::sin(latitude), w = 1 - e2 * s * s;
    north_ = a * (1 - e2) / std::pow(w, 1.5) + height;
    east_ = (a / std::sqrt(w) + height) * std::cos(latitude);
  }
  Eigen::Vector2d NorthEast(double latitude, double longitude) const {
    return {north_ * (latitude - latitude_), east_ * std::remainder(longitude - longitude_, 2 * kPi)};
  }
  Eigen::Vector2d LatitudeLongitude(const Eigen::Vector2d& north_east) const {
    return {latitude_ + north_east.x() / north_,
            std::remainder(longitude_ + north_east.y() / east_, 2 * kPi)};
  }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  double latitude_, longitude_, north_ = 0, east_ = 0;
};

}  // namespace kestrel::control
