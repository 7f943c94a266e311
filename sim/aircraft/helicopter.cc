// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/helicopter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/gravity.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"
#include "sim/aircraft/rotor/rotor.h"

namespace kestrel::sim {
namespace {

Eigen::Vector3d MainHub(const HelicopterParameters& p) { return {0, 0, -p.rotor_height_m}; }
Eigen::Vector3d TailHub(const HelicopterParameters& p) { return {-p.tail_arm_m, 0, -p.tail_height_m}; }
// Where the tail rotor pushes with positive pitch: so that it turns the aircraft as the main rotor turns.
Eigen::Vector3d TailThrust(const HelicopterParameters& p) { return {0, -static_cast<double>(SpinOf(p)), 0}; }

double Lagged(double value, double command, double time_s, double dt_s) {
  return command + (value - command) * std::exp(-dt_s / time_s);
}

double StepServo(double pitch, double command, const ActuatorCondition& condition, double time_s,
                 double dt_s) {
  if (condition.stuck) return pitch;
  return Lagged(pitch, condition.off ? 0 : command + condition.offset, condition.slowness * time_s, dt_s);
}

DriveState StepDrive(const DriveParameters& p, const ActuatorCondition& condition, const DriveState& state,
                     bool running, double load_n_m, double dt_s) {
  DriveParameters now = p;
  now.power_w *= 1 - condition.loss;
  now.response_s *= condition.stuck ? 1e9 : condition.slowness;
  return StepDrive(now, state, running && !condition.off, load_n_m, dt_s);
}

// Lift and drag of a fin, N, along its normal: speeds of the air's relative flow along and across it.
double FinForce(const FinParameters& p, double along_m_s, double across_m_s) {
  return -kAirDensity / 2 * p.area_m2 * (p.lift_slope_per_rad * std::abs(along_m_s) + std::abs(across_m_s)) *
         across_m_s;
}

}  // namespace

HelicopterLoads LoadsOf(const HelicopterParameters& p, const HelicopterState& state,
                        const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B, double height_m) {
  const Eigen::Vector3d hub = v_B + w_B.cross(MainHub(p)), tail = v_B + w_B.cross(TailHub(p));
  HelicopterLoads loads;
  loads.flow = {std::hypot(hub.x(), hub.y()), -hub.z(), GroundEffect(p.rotor.radius_m, height_m)};
  loads.tail_flow = {std::hypot(tail.x(), tail.z()), tail.dot(TailThrust(p)), 1};
  const double speed = state.drive.speed_rad_s;
  loads.rotor = LoadsOf(p.rotor, speed, state.collective, state.induced_m_s, loads.flow);
  loads.tail =
      LoadsOf(p.tail_rotor, p.tail_gear * speed, state.tail_pitch, state.tail_induced_m_s, loads.tail_flow);
  return loads;
}

HelicopterState StepHelicopter(const HelicopterParameters& p, const HelicopterState& state,
                               const HelicopterControls& controls, const Eigen::Vector3d& v_B,
                               const Eigen::Vector3d& w_B, double height_m, double dt_s,
                               const ActuatorConditions& conditions) {
  const HelicopterLoads loads = LoadsOf(p, state, v_B, w_B, height_m);
  const double speed = state.drive.speed_rad_s, spin = static_cast<int>(SpinOf(p));
  HelicopterState next = state;

  const double collective =
      std::clamp(controls.collective, Radians(p.collective_low_deg), Radians(p.collective_high_deg));
  const Eigen::Vector2d cyclic = Limited(controls.cyclic, Radians(p.cyclic_limit_deg));
  const auto& servos = conditions.servos;
  next.collective = StepServo(state.collective, collective, servos[0], p.servo_s, dt_s);
  next.cyclic.x() = StepServo(state.cyclic.x(), cyclic.x(), servos[1], p.servo_s, dt_s);
  next.cyclic.y() = StepServo(state.cyclic.y(), cyclic.y(), servos[2], p.servo_s, dt_s);
  double tail_pitch = 0;
  if (controls.running) {
    tail_pitch = HeadingGyro(p.heading_gyro, spin * (controls.yaw_rate - w_B.z()), controls.tail_pitch,
                             Radians(p.tail_low_deg), Radians(p.tail_high_deg), dt_s, next.heading_integral);
  } else {
    next.heading_integral = 0;
  }
  next.tail_pitch = StepServo(state.tail_pitch, tail_pitch, servos[3], p.servo_s, dt_s);

  next.induced_m_s = StepInduced(p.rotor, speed, state.collective, state.induced_m_s, loads.flow, dt_s);
  next.tail_induced_m_s = StepInduced(p.tail_rotor, p.tail_gear * speed, state.tail_pitch,
                                      state.tail_induced_m_s, loads.tail_flow, dt_s);
  const FlappingInput input{state.cyclic,
                            speed,
                            state.collective,
                            VelocityThroughDisc(state.induced_m_s, loads.flow) + loads.flow.climb_m_s,
                            v_B + w_B.cross(MainHub(p)),
                            w_B};
  next.flapping =
      StepFlapping(p.rotor, p.flapping, SpinOf(p), p.drive.speed_rad_s, state.flapping, input, dt_s);
  next.drive = StepDrive(p.drive, conditions.motors[0], state.drive, controls.running,
                         loads.rotor.torque_n_m + p.tail_gear * loads.tail.torque_n_m, dt_s);
  next.azimuth = std::remainder(state.azimuth + spin * dt_s * next.drive.speed_rad_s, 2 * std::numbers::pi);
  return next;
}

Wrench AerodynamicWrench(const HelicopterParameters& p, const HelicopterState& state,
                         const Eigen::Vector3d& v_B, const Eigen::Vector3d& w_B, double height_m) {
  const HelicopterLoads loads = LoadsOf(p, state, v_B, w_B, height_m);
  Wrench total;
  const auto add = [&](const Eigen::Vector3d& at, const Eigen::Vector3d& force) {
    total.force += force;
    total.torque += at.cross(force);
  };

  const double a = state.flapping.disc.x(), b = state.flapping.disc.y();
  const Eigen::Vector3d hub = v_B + w_B.cross(MainHub(p));
  const double drag = kAirDensity / 4 * DiscArea(p.rotor) * Solidity(p.rotor) * p.rotor.drag_coefficient *
                      state.drive.speed_rad_s * p.rotor.radius_m;
  add(MainHub(p), loads.rotor.thrust_n * Eigen::Vector3d(-a, b, -1).normalized() -
                      drag * Eigen::Vector3d(hub.x(), hub.y(), 0));
  const double into_rotor = DriveTorque(p.drive, state.drive) - p.tail_gear * loads.tail.torque_n_m;
  total.torque += Eigen::Vector3d(p.flapping.hub_stiffness_n_m * b, p.flapping.hub_stiffness_n_m * a,
                                  -static_cast<int>(SpinOf(p)) * into_rotor);

  add(TailHub(p), loads.tail.thrust_n * TailThrust(p));
  const Eigen::Vector3d tail = v_B + w_B.cross(TailHub(p));
  add(TailHub(p), {0, FinForce(p.vertical_fin, std::hypot(tail.x(), tail.z()), tail.y()), 0});
  const Eigen::Vector3d at_fin(-p.horizontal_fin_arm_m, 0, 0), fin = v_B + w_B.cross(at_fin);
  add(at_fin, {0, 0, FinForce(p.horizontal_fin, fin.x(), fin.z())});

  const Eigen::Vector3d v_fuselage =
      v_B - Eigen::Vector3d(0, 0, VelocityThroughDisc(state.induced_m_s, loads.flow));
  add(Eigen::Vector3d::Zero(),
      -0.5 * kAirDensity * v_fuselage.norm() * p.drag_area_m2.cwiseProduct(v_fuselage));
  return total;
}

HelicopterState HoverState(const HelicopterParameters& p) {
  HelicopterState state;
  const double speed = p.drive.speed_rad_s, tail_speed = p.tail_gear * speed;
  state.drive.speed_rad_s = state.drive.target_rad_s = speed;
  // thrust: the weight, and what the wake presses on the fuselage, k T
  const double wake_share = kAirDensity / 2 * p.drag_area_m2.z() * std::pow(SteadyInduced(p.rotor, 1, 0), 2);
  const double thrust = p.mass_kg * kGravity_m_s2 / (1 - wake_share);
  state.induced_m_s = SteadyInduced(p.rotor, thrust, 0);
  state.collective = PitchFor(p.rotor, speed, thrust, 0);
  const double torque = LoadsOf(p.rotor, speed, state.collective, state.induced_m_s, {}).torque_n_m;
  const double tail_thrust = torque / p.tail_arm_m;
  state.tail_induced_m_s = SteadyInduced(p.tail_rotor, tail_thrust, 0);
  state.tail_pitch = PitchFor(p.tail_rotor, tail_speed, tail_thrust, 0);
  const double tail_torque =
      LoadsOf(p.tail_rotor, tail_speed, state.tail_pitch, state.tail_induced_m_s, {}).torque_n_m;
  state.drive.power_w = (torque + p.tail_gear * tail_torque) * speed;
  state.drive.integral = std::min(1.0, state.drive.power_w / p.drive.power_w);
  return state;
}

HelicopterControls HoverControls(const HelicopterState& hover) {
  return {hover.collective, Eigen::Vector2d::Zero(), 0, hover.tail_pitch, true};
}

double HoverPower_w(const HelicopterParameters& p) { return HoverState(p).drive.power_w; }

Helicopter::Helicopter(const HelicopterParameters& parameters, mjModel* model, bool turning,
                       const char* body_name)
    : parameters_(parameters), body_(parameters.mass_kg, parameters.inertia_kg_m2, model, body_name) {
  if (!turning) return;
  state_ = HoverState(parameters);
  controls_ = HoverControls(state_);
}

void Helicopter::Apply(mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m) {
  const Pose X_NB = body_.X_NB(data);
  const Eigen::Vector3d v_B = X_NB.R.conjugate() * (body_.v_N(data) - wind_N), w_B = body_.w_B(data);
  const double height_m = -(X_NB * MainHub(parameters_)).z() - surface_m;
  state_ = StepHelicopter(parameters_, state_, controls_, v_B, w_B, height_m, dt_s, conditions_);
  body_.Push(AerodynamicWrench(parameters_, state_, v_B, w_B, height_m), data);
}

void Helicopter::Disturb(SensorReadings& readings) const {
  const DriveParameters& drive = parameters_.drive;
  const ImuSample shake = ShakeAt(parameters_.shake, state_.azimuth, parameters_.rotor.blades,
                                  state_.drive.speed_rad_s / drive.speed_rad_s);
  readings.imu.w_B += shake.w_B;
  readings.imu.specific_force_B += shake.specific_force_B;
  readings.rotor_rad_s = state_.drive.speed_rad_s;
}

}  // namespace kestrel::sim
