// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/multirotor_stabiliser.h"

#include <algorithm>

namespace kestrel::sim {
namespace {

// Fast against the identified model that is to be followed, slow against the motors.
constexpr double kInnerFrequency_rad_s = 20;
constexpr double kInnerDamping = 0.9;
constexpr double kYawInnerFrequency_rad_s = 8;

}  // namespace

RotorSpeeds MultirotorStabiliser::Step(double /*dt_s*/, const AttitudeDemand& demand,
                                       const SensedMotion& sensed) {
  const Eigen::Vector3d frequency(kInnerFrequency_rad_s, kInnerFrequency_rad_s, kYawInnerFrequency_rad_s);
  const Eigen::Vector3d alpha = demand.acceleration_B + frequency.cwiseAbs2().cwiseProduct(demand.error_B) +
                                2 * kInnerDamping * frequency.cwiseProduct(demand.w_B - sensed.w_B);
  const Eigen::Vector3d torque_B = aircraft_.inertia_kg_m2.cwiseProduct(alpha);
  const RotorSpeeds speeds = Allocate(aircraft_, demand.thrust_n, torque_B);
  const double most = aircraft_.rotor.max_speed_rad_s * 0.999;
  limited_ = std::any_of(speeds.begin(), speeds.end(), [&](double s) { return s >= most; });
  return speeds;
}

}  // namespace kestrel::sim
