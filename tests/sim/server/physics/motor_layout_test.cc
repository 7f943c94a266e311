// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/motor_layout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

// More thrust of a motor turns the aircraft as the autopilot that numbers it so expects: away from it, and
// against its spin.
TEST(MotorLayout, EachMotorTurnsTheAircraftAsItsAutopilotExpects) {
  const MultirotorParameters pelican;
  int checked = 0;
  for (const MotorLayout& layout : MotorLayouts()) {
    const MotorMapping mapping(layout.name, pelican);
    for (std::size_t i = 0; i < 4; ++i, ++checked) {
      std::array<double, 4> commands{};
      commands[i] = 0.5;
      const auto speeds = std::get<RotorSpeeds>(mapping.Speeds(commands, 0));
      const Wrench wrench = AerodynamicWrench(pelican, speeds, Eigen::Vector3d::Zero(),
                                              Eigen::Vector3d::Zero(), {1e6, 1e6, 1e6, 1e6});
      const Eigen::Vector3d torque_A = mapping.R_BA().conjugate() * wrench.torque;
      const double thrust = -wrench.force.z(), bearing = Radians(layout.motors[i].bearing_deg);
      const double max_thrust =
          pelican.rotor.thrust_coefficient_n_s2 * std::pow(pelican.rotor.max_speed_rad_s, 2);
      EXPECT_NEAR(thrust, max_thrust / 2, 1e-9);
      EXPECT_NEAR(torque_A.x(), -thrust * pelican.arm_m * std::sin(bearing), 1e-9) << layout.name << i;
      EXPECT_NEAR(torque_A.y(), thrust * pelican.arm_m * std::cos(bearing), 1e-9) << layout.name << i;
      const double reaction = thrust * pelican.rotor.moment_coefficient_m;  // clockwise is positive
      EXPECT_NEAR(torque_A.z(), layout.motors[i].spin == Spin::kCounterclockwise ? reaction : -reaction, 1e-9)
          << layout.name << i;
    }
  }
  EXPECT_EQ(checked, 8);
}

TEST(MotorLayout, TheThrustCurveIsTheInverseOfTheAutopilots) {
  for (const double curvature : {0.0, 0.3, 0.65, 1.0}) {
    for (const double wanted : {0.0, 0.1, 0.45, 0.9, 1.0}) {
      // ArduPilot's AP_Motors and PX4's FunctionMotors make a command of a thrust so.
      const double c = curvature;
      const double command =
          c == 0 ? wanted : (c - 1 + std::sqrt((1 - c) * (1 - c) + 4 * c * wanted)) / (2 * c);
      EXPECT_NEAR(ThrustShare(command, curvature), wanted, 1e-12);
    }
  }
  EXPECT_EQ(ThrustShare(-1, 0), 0);
  EXPECT_EQ(ThrustShare(7, 0.65), 1);
  EXPECT_EQ(ThrustShare(std::numeric_limits<double>::quiet_NaN(), 0), 0);
  EXPECT_EQ(ThrustShare(std::numeric_limits<double>::infinity(), 1), 0);
}

}  // namespace
}  // namespace kestrel::sim
