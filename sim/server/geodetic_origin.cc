// SPDX-License-Identifier: Apache-2.0
#include "sim/server/geodetic_origin.h"

#include "control/link/local_geodesy.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {

GeodeticPosition GeodeticOf(const GeodeticOrigin& origin, const Eigen::Vector3d& p_N) {
  const control::LocalPlane plane(Radians(origin.latitude_deg), Radians(origin.longitude_deg),
                                  origin.altitude_m);
  const Eigen::Vector2d place = plane.LatitudeLongitude(p_N.head<2>());
  return {Degrees(place.x()), Degrees(place.y()), origin.altitude_m - p_N.z()};
}

}  // namespace kestrel::sim
