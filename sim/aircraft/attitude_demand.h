// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::sim {

// What an autopilot's outer loops ask of the inner loop that moves an airframe's rotors or servos.
struct AttitudeDemand {
  Eigen::Vector3d error_B;         // rotation vector from the attitude in use to the one wanted, rad
  Eigen::Vector3d w_B;             // the rate wanted, rad/s
  Eigen::Vector3d acceleration_B;  // and how it is to change, rad/s^2
  double thrust_n = 0;             // along -z of B
};

// What the inner loop knows of the motion.
struct SensedMotion {
  Eigen::Vector3d w_B;     // rad/s
  double climb_m_s = 0;    // along -z of B
  double rotor_rad_s = 0;  // of the tachometer of a helicopter
};

}  // namespace kestrel::sim
