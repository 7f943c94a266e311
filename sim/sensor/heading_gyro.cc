// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/heading_gyro.h"

#include <algorithm>

namespace kestrel::sim {

double HeadingGyro(const HeadingGyroParameters& p, double error_rad_s, double mixed, double low, double high,
                   double dt_s, double& integral) {
  const double more = dt_s * p.integral * error_rad_s;
  const double proportional = mixed + p.gain_s * error_rad_s, pitch = proportional + integral + more;
  if ((pitch <= high || more < 0) && (pitch >= low || more > 0)) integral += more;
  return std::clamp(proportional + integral, low, high);
}

}  // namespace kestrel::sim
