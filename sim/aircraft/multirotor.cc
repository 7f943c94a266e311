// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/multirotor.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace kestrel::sim {
namespace {

// A faulty motor: thrust goes with the square of the speed.
double StepMotor(const RotorParameters& p, const ActuatorCondition& condition, double speed_rad_s,
                 double command_rad_s, double dt_s) {
  if (condition.stuck) return speed_rad_s;
  const double command = condition.off ? 0 : std::sqrt(1 - condition.loss) * command_rad_s;
  return StepMotor(p, speed_rad_s, command, dt_s / condition.slowness);
}

Wrench WrenchOf(const MultirotorParameters& p, const RotorLayout& layout, const RotorSpeeds& speeds,
                const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B,
                const std::array<double, kMaxRotors>& heights_m) {
  Wrench total;
  total.force = -0.5 * kAirDensity * v_B.norm() * p.drag_area_m2.cwiseProduct(v_B);
  for (std::size_t i = 0; i < layout.count; ++i) {
    const Wrench hub = RotorWrench(p.rotor, speeds[i], layout.spins[i], v_B + w_B.cross(layout.hubs_B[i]),
                                   GroundEffect(p.rotor.radius_m, heights_m[i]));
    total.force += hub.force;
    total.torque += hub.torque + layout.hubs_B[i].cross(hub.force);
  }
  return total;
}

}  // namespace

RotorLayout LayoutOf(const MultirotorParameters& p) {
  const double l = p.arm_m, z = -p.rotor_height_m;
  RotorLayout layout;
  if (p.rotors.empty()) {
    layout.count = 4;
    layout.hubs_B = {{{l, 0, z}, {0, l, z}, {-l, 0, z}, {0, -l, z}}};
    layout.spins = {Spin::kClockwise, Spin::kCounterclockwise, Spin::kClockwise, Spin::kCounterclockwise};
    return layout;
  }
  layout.count = std::min(p.rotors.size(), kMaxRotors);
  for (std::size_t i = 0; i < layout.count; ++i) {
    layout.hubs_B[i] = {p.rotors[i].x_m, p.rotors[i].y_m, z};
    layout.spins[i] = p.rotors[i].spin == "clockwise" ? Spin::kClockwise : Spin::kCounterclockwise;
  }
  return layout;
}

RotorLimits LimitsOf(const RotorParameters& rotor) {
  return {rotor.thrust_coefficient_n_s2 * rotor.max_speed_rad_s * rotor.max_speed_rad_s,
          rotor.moment_coefficient_m};
}

RotorSpeeds Allocate(const MultirotorParameters& p, double thrust, const Eigen::Vector3d& torque_B) {
  const double k_f = p.rotor.thrust_coefficient_n_s2;
  const double most = k_f * p.rotor.max_speed_rad_s * p.rotor.max_speed_rad_s;  // thrust of one rotor
  const auto speed_of = [&](double t) { return std::sqrt(std::clamp(t, 0.0, most) / k_f); };
  RotorSpeeds speeds{};
  if (!p.rotors.empty()) {
    const auto thrusts = MixThrusts(LayoutOf(p), LimitsOf(p.rotor), thrust, torque_B);
    std::ranges::transform(thrusts, speeds.begin(), speed_of);
    return speeds;
  }

  // The same for a plus, in closed form.
  double roll = torque_B.x() / (2 * p.arm_m);   // more on the left, less on the right
  double pitch = torque_B.y() / (2 * p.arm_m);  // more in front, less at the back
  const double swing = std::max(std::abs(roll), std::abs(pitch));
  if (swing > most / 2) {
    roll *= most / 2 / swing;
    pitch *= most / 2 / swing;
  }
  const double margin = std::min(swing, most / 2);
  const double mean = std::clamp(thrust / 4, margin, most - margin);
  // yaw loads the counterclockwise pair by what it takes off the clockwise pair
  const double yaw = std::clamp(torque_B.z() / (4 * p.rotor.moment_coefficient_m),
                                std::max(std::abs(pitch) + mean - most, std::abs(roll) - mean),
                                std::min(mean - std::abs(pitch), most - std::abs(roll) - mean));

  const std::array<double, 4> thrusts = {mean + pitch - yaw, mean - roll + yaw, mean - pitch - yaw,
                                         mean + roll + yaw};
  std::ranges::transform(thrusts, speeds.begin(), speed_of);
  return speeds;
}

Wrench AerodynamicWrench(const MultirotorParameters& p, const RotorSpeeds& speeds, const Eigen::Vector3d& v_B,
                         const Eigen::Vector3d& w_B, const std::array<double, kMaxRotors>& heights_m) {
  return WrenchOf(p, LayoutOf(p), speeds, v_B, w_B, heights_m);
}

Multirotor::Multirotor(const MultirotorParameters& parameters, mjModel* model, const char* body_name)
    : parameters_(parameters),
      layout_(LayoutOf(parameters)),
      body_(parameters.mass_kg, parameters.inertia_kg_m2, model, body_name),
      gravity_m_s2_(mju_norm3(model->opt.gravity)) {}

void Multirotor::Command(const RotorSpeeds& speeds) {
  for (std::size_t i = 0; i < layout_.count; ++i)
    command_[i] = std::clamp(speeds[i], 0.0, parameters_.rotor.max_speed_rad_s);
}

void Multirotor::Apply(mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m) {
  for (std::size_t i = 0; i < layout_.count; ++i)
    speeds_[i] = StepMotor(parameters_.rotor, conditions_.motors[i], speeds_[i], command_[i], dt_s);

  const Pose X_NB = body_.X_NB(data);
  std::array<double, kMaxRotors> heights_m{};
  for (std::size_t i = 0; i < layout_.count; ++i) heights_m[i] = -(X_NB * layout_.hubs_B[i]).z() - surface_m;

  body_.Push(WrenchOf(parameters_, layout_, speeds_, X_NB.R.conjugate() * (body_.v_N(data) - wind_N),
                      body_.w_B(data), heights_m),
             data);
}

bool Multirotor::saturated() const {
  // Allocate reaches the limits to within rounding
  const double most = parameters_.rotor.max_speed_rad_s;
  const auto [low, high] = std::ranges::minmax(std::span(command_).first(layout_.count));
  return high > (1 - 1e-9) * most || (low < 1e-6 * most && high > 1e-6 * most);
}

double Multirotor::HoverSpeed() const {
  return std::sqrt(parameters_.mass_kg * gravity_m_s2_ /
                   (static_cast<double>(layout_.count) * parameters_.rotor.thrust_coefficient_n_s2));
}

}  // namespace kestrel::sim
