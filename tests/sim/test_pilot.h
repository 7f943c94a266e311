// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/tait_bryan.h"
#include "sim/aircraft/multirotor.h"
#include "tests/sim/published_layouts.h"

namespace kestrel::sim {

// What an autopilot from outside knows of it, in its own frame A: forward, right, down.
struct PilotState {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero(), v_N = Eigen::Vector3d::Zero();
  Eigen::Quaterniond R_NA = Eigen::Quaterniond::Identity();
  Eigen::Vector3d w_A = Eigen::Vector3d::Zero();
};

// A simple autopilot with motors numbered and turning as PX4's and ArduPilot's documentation has them:
// it climbs from where it began to a height and stays there.
class TestPilot {
 public:
  // motors: where they are. curvature: of their thrust curve. aircraft: as it was told to the pilot.
  TestPilot(std::vector<PublishedMotor> motors, double curvature, MultirotorParameters aircraft = {})
      : motors_(std::move(motors)), curvature_(curvature), p_(std::move(aircraft)) {}

  // Commands of motor 1 and on, 0 to 1. t_s: since take-off was asked for.
  std::array<double, kMaxRotors> Fly(double t_s, const PilotState& s, double height_m) const {
    const Eigen::Vector3d p_wanted(0, 0, -std::min(height_m, 0.8 * t_s));
    const Eigen::Vector3d v_wanted = 1.0 * (p_wanted - s.p_N);
    return Follow(v_wanted.cwiseMax(-1).cwiseMin(1), s);
  }
  // The same for a velocity in N.
  std::array<double, kMaxRotors> Follow(const Eigen::Vector3d& v_wanted, const PilotState& s) const {
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

    double sum_x2 = 0, sum_y2 = 0;
    for (const PublishedMotor& m : motors_) sum_x2 += m.x * m.x, sum_y2 += m.y * m.y;
    const auto count = static_cast<double>(motors_.size());
    std::array<double, kMaxRotors> commands{};
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      const PublishedMotor& m = motors_[i];
      const double newtons = thrust / count - m.y * torque.x() / sum_y2 + m.x * torque.y() / sum_x2 +
                             m.yaw * torque.z() / (count * p_.rotor.moment_coefficient_m);
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

  std::vector<PublishedMotor> motors_;
  double curvature_;
  MultirotorParameters p_;
  double heading_ = 0;
};

}  // namespace kestrel::sim
