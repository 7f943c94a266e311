// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/rotor_shake.h"

#include <cmath>

namespace kestrel::sim {

ImuSample ShakeAt(const RotorShake& s, double azimuth, int blades, double share) {
  const double turn = azimuth, pass = blades * azimuth, k = share * share;
  ImuSample imu;
  imu.specific_force_B = k * Eigen::Vector3d(s.turn_m_s2 * std::cos(turn), s.turn_m_s2 * std::sin(turn),
                                             s.blade_m_s2 * std::cos(pass));
  // a force at the hub, above the centre of mass, tilts the aircraft about the axis across it
  imu.w_B = k * Eigen::Vector3d(s.turn_rad_s * std::sin(turn),
                                -s.turn_rad_s * std::cos(turn) + s.blade_rad_s * std::sin(pass), 0);
  return imu;
}

}  // namespace kestrel::sim
