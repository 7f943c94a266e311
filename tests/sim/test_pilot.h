// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "sim/aircraft/multirotor.h"

namespace kestrel::sim {

// What an autopilot from outside knows of it, in its own frame A: forward, right, down.
struct PilotState {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero(), v_N = Eigen::Vector3d::Zero();
  Eigen::Quaterniond R_NA = Eigen::Quaterniond::Identity();
  Eigen::Vector3d w_A = Eigen::Vector3d::Zero();
};

// A simple autopilot with four motors, numbered and turning as PX4's and ArduPilot's documentation has them:
// it climbs from where it began to a height and stays there.
class TestPilot {
 public:
  // x_layout: the motors are at 45 degrees from the axes of A. curvature: of its motors' thrust curve.
  TestPilot(bool x_layout, double curvature) : x_layout_(x_layout), curvature_(curvature) {}

  // Commands of motors 1 to 4, 0 to 1. t_s: since take-off was asked for.
  std::array<double, 4> Fly(double t_s, const PilotState& s, double height_m) const {
    const Eigen::Vector3d p_wanted(0, 0, -std::min(height_m, 0.8 * t_s));
    Eigen::Vector3d v_wanted = 1.0 * (p_wanted - s.p_N);
    v_wanted = v_wanted.cwiseMax(-1).cwiseMin(1);
    Eigen::Vector3d a = 2.0 * (v_wanted - s.v_N);
    a.z() = 4.0 * (v_wanted.z() - s.v_N.z());
    a = a.cwiseMax(-3).cwiseMin(3);
    const Eigen::Vector3d a_H = HeadingRotation(-YawOf(s.R_NA)) * Eigen::Vector3d(a.x(), a.y(), 0);
    const TaitBryan now = TaitBryanFromRotation(s.R_NA.toRotationMatrix());
    const double pitch = -a_H.x() / kGravity, roll = a_H.y() / kGravity;
    const Eigen::Vector3d error(roll - now.roll, pitch - now.pitch, WrapAngle(heading_ - now.yaw));
    const Eigen::Vector3d stiffness(100, 100, 9), damping(14, 14, 6);
    const Eigen::Vector3d torque =
        p_.inertia_kg_m2.cwiseProduct(stiffness.cwiseProduct(error) - damping.cwiseProduct(s.w_A));
    const double thrust = p_.mass_kg * (kGravity - a.z()) / (std::cos(now.roll) * std::cos(now.pitch));

    // Right, left, front, back; of an X: front right, back left, front left, back right.
    const std::array<double, 4> bearings_deg =
        x_layout_ ? std::array<double, 4>{45, 225, 315, 135} : std::array<double, 4>{90, 270, 0, 180};
    constexpr std::array<double, 4> kCounterclockwise = {1, 1, -1, -1};
    std::array<double, 4> commands{};
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = std::cos(Radians(bearings_deg[i])), y = std::sin(Radians(bearings_deg[i]));
      const double newtons = thrust / 4 + (-y * torque.x() + x * torque.y()) / (2 * p_.arm_m) +
                             kCounterclockwise[i] * torque.z() / (4 * p_.rotor.moment_coefficient_m);
      const double max_thrust = p_.rotor.thrust_coefficient_n_s2 * std::pow(p_.rotor.max_speed_rad_s, 2);
      commands[i] = CommandFor(std::clamp(newtons / max_thrust, 0.0, 1.0));
    }
    return commands;
  }
  void KeepHeading(double heading) { heading_ = heading; }

 private:
  static constexpr double kGravity = 9.80665;
  double CommandFor(double share) const {
    const double c = curvature_;
    return c == 0 ? share : (c - 1 + std::sqrt((1 - c) * (1 - c) + 4 * c * share)) / (2 * c);
  }

  bool x_layout_;
  double curvature_;
  MultirotorParameters p_;  // the Pelican
  double heading_ = 0;
};

}  // namespace kestrel::sim
