// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// Where the origin of N is on the earth. The default is Madrid, whose magnetic field the sensors have: an
// autopilot that compares it with a model of the earth's must find itself there.
struct GeodeticOrigin {
  double latitude_deg = 40.4168, longitude_deg = -3.7038;  // WGS 84
  double altitude_m = 657;                                 // above the sea
};

inline void Fields(FieldVisitor& v, GeodeticOrigin& o) {
  v({"latitude_deg", "latitude of the origin of N, WGS 84"}, o.latitude_deg, -80.0, 80.0);
  v({"longitude_deg", "longitude of the origin of N, WGS 84"}, o.longitude_deg, -180.0, 180.0);
  v({"altitude_m", "altitude of the origin of N above the sea"}, o.altitude_m, -400.0, 5000.0);
}

struct GeodeticPosition {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
};
// On the plane that touches the earth there (control/link/local_geodesy.h): good to 2 mm at 100 m from the
// origin and to 0.2 m at 1 km.
GeodeticPosition GeodeticOf(const GeodeticOrigin& origin, const Eigen::Vector3d& p_N);

}  // namespace kestrel::sim
