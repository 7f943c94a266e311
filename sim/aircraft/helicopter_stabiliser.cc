// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/helicopter_stabiliser.h"

#include <algorithm>
#include <cmath>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kReadyShare = 0.97;  // of the governed rotor speed
constexpr double kAloftShare = 0.5;  // of the weight: with less thrust the skids stand, and nothing is summed
constexpr double kIntegralLimit = 0.3;  // rad s

// The tail rotor's pitch that holds the main rotor's torque.
double TailPitchAgainst(const HelicopterParameters& p, double speed_rad_s, double collective, double thrust_n,
                        double climb_m_s) {
  const double induced = SteadyInduced(p.rotor, thrust_n, climb_m_s);
  const double torque = LoadsOf(p.rotor, speed_rad_s, collective, induced, {0, climb_m_s, 1}).torque_n_m;
  return PitchFor(p.tail_rotor, p.tail_gear * speed_rad_s, torque / p.tail_arm_m, 0);
}

}  // namespace

HelicopterControls HelicopterStabiliser::Step(double dt_s, const AttitudeDemand& demand,
                                              const SensedMotion& sensed) {
  const HelicopterParameters& p = aircraft_;
  const HelicopterGains& g = p.gains;
  const double speed = std::max(sensed.rotor_rad_s, 0.1 * p.drive.speed_rad_s);
  const double weight = p.mass_kg * kGravity_m_s2;
  limited_ = false;

  HelicopterControls controls;
  controls.running = true;
  const double thrust = std::clamp(demand.thrust_n, 0.0, MaxThrust(p.rotor, speed));
  const double low = Radians(p.collective_low_deg), high = Radians(p.collective_high_deg);
  const double collective = PitchFor(p.rotor, speed, thrust, sensed.climb_m_s);
  controls.collective = std::clamp(collective, low, high);
  limited_ = collective > high || thrust < demand.thrust_n;

  // longitudinal tilt pitches, lateral tilt rolls
  const auto tilting = [](const Eigen::Vector3d& v_B) { return Eigen::Vector2d(v_B.y(), v_B.x()); };
  const Eigen::Vector2d error = tilting(demand.error_B), rate = tilting(sensed.w_B);
  const double w = g.attitude_rad_s;
  const Eigen::Vector2d alpha = tilting(demand.acceleration_B) +
                                w * w * (error + g.integral_per_s * integral_) +
                                2 * g.attitude_damping * w * (tilting(demand.w_B) - rate);
  const double stiffness =
      p.flapping.hub_stiffness_n_m + std::max(thrust, kAloftShare * weight) * p.rotor_height_m;
  const Eigen::Vector2d wanted = tilting(p.inertia_kg_m2).cwiseProduct(alpha) / stiffness;

  FlappingInput input;
  input.speed_rad_s = speed;
  input.w_B = sensed.w_B;
  const FlappingState drift =
      FlappingRate(p.rotor, p.flapping, SpinOf(p), p.drive.speed_rad_s, flapping_, input);  // without cyclic
  const double flap_time = FlapTime(p.rotor, p.flapping, speed);
  const Eigen::Vector2d cyclic = flap_time * (g.disc_rad_s * (wanted - flapping_.disc) - drift.disc);
  const double limit = Radians(p.cyclic_limit_deg);
  controls.cyclic = cyclic.norm() > limit ? Eigen::Vector2d(cyclic * (limit / cyclic.norm())) : cyclic;
  const bool cyclic_limited = cyclic.norm() > limit;
  limited_ = limited_ || cyclic_limited;
  if (thrust < kAloftShare * weight) {
    integral_.setZero();
  } else if (!cyclic_limited) {
    integral_ = (integral_ + dt_s * error).cwiseMax(-kIntegralLimit).cwiseMin(kIntegralLimit);
  }
  cyclic_ = controls.cyclic + (cyclic_ - controls.cyclic) * std::exp(-dt_s / p.servo_s);
  input.cyclic = cyclic_;
  flapping_ = StepFlapping(p.rotor, p.flapping, SpinOf(p), p.drive.speed_rad_s, flapping_, input, dt_s);

  controls.yaw_rate = demand.w_B.z() + g.heading_per_s * demand.error_B.z();
  controls.tail_pitch = TailPitchAgainst(p, speed, controls.collective, thrust, sensed.climb_m_s);
  return controls;
}

void HelicopterStabiliser::Stop() {
  integral_.setZero();
  cyclic_.setZero();
  flapping_ = {};
  limited_ = false;
}

bool HelicopterStabiliser::Ready(const SensedMotion& sensed) const {
  return sensed.rotor_rad_s > kReadyShare * aircraft_.drive.speed_rad_s;
}

}  // namespace kestrel::sim
