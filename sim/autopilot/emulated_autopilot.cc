// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/emulated_autopilot.h"

#include <algorithm>
#include <cmath>

#include "base/gravity.h"
#include "control/law/level_acceleration.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kYawGain_per_s = 1.0;
constexpr double kIntegralLimit_m_s2 = 6;
constexpr double kDragTime_s = 0.15;
constexpr double kRateLimit_rad_s = 6;  // of roll and pitch, where rates are asked for themselves
constexpr double kTakeOffClimb_m_s = 0.7;
constexpr double kClearOfGround_m = 0.3;
// Touch-down: asked to sink, yet not sinking, for this long; then the thrust is taken away bit by bit, and an
// aircraft that still does not sink, and that something carries in its place, stands on the ground. In the
// air its accelerometer feels the thrust go long before it falls; but not where it leans so far that its thrust
// is much more than its weight, as it does on no ground and no deck.
constexpr double kTouchDescent_m_s = 0.12;
constexpr double kTouchStill_m_s = 0.09;
constexpr double kTouchTime_s = 0.4;
constexpr double kTouchSpool_s = 0.4;
constexpr double kTouchFalling_m_s = 0.35;
constexpr double kTouchThrottle = 0.4;
constexpr double kTouchThrottleMoving =
    0.05;  // on what moves, where sinking tells less: until nothing else carries
constexpr double kTouchCarried_m_s2 = 0.8 * kGravity_m_s2;
constexpr double kCarriedTime_s = 0.05;
const double kTouchUpright = std::cos(Radians(20));

}  // namespace

void EmulatedAutopilot::AxisState::Step(double dt_s, const AxisLoop& loop, double command) {
  const double w = loop.natural_frequency_rad_s;
  acceleration = w * w * (loop.gain * command - angle) - 2 * loop.damping * w * rate;
  rate += dt_s * acceleration;  // symplectic Euler: stable and exact enough at w dt of a hundredth
  angle += dt_s * rate;
}

EmulatedAutopilot::EmulatedAutopilot(const AutopilotParameters& parameters, const SensorParameters& sensors,
                                     const AirframeParameters& aircraft, const Pose& X_NB, bool flying,
                                     const Eigen::Vector3d& gyro_bias)
    : parameters_(parameters),
      aircraft_(aircraft),
      stabiliser_(MakeStabiliser(aircraft)),
      navigation_(sensors, parameters.command_timeout_s, X_NB, gyro_bias),
      mode_(flying ? control::FlightMode::kPosition : control::FlightMode::kStopped) {
  hold_ = {X_NB.p, YawOf(X_NB.R)};
  setpoint_ = hold_;
  yaw_.angle = yaw_command_ = hold_.yaw;
}

void EmulatedAutopilot::Send(const control::Setpoint& setpoint) {
  setpoint_ = setpoint;
  setpoint_age_s_ = 0;
  if (mode_ == control::FlightMode::kStopped) {
    const auto* position = std::get_if<control::PositionSetpoint>(&setpoint);
    if (!position || !(position->p_N.z() < navigation_.InUse().X_NB().p.z() - kClearOfGround_m)) return;
    mode_ = control::FlightMode::kTakeOff;
    const TaitBryan now = TaitBryanFromRotation(navigation_.InUse().X_NB().R.toRotationMatrix());
    hold_ = {navigation_.InUse().X_NB().p, now.yaw};
    roll_ = {}, pitch_ = {}, yaw_ = {};
    yaw_.angle = yaw_command_ = now.yaw;
    integral_N_.setZero();
    CommandVelocity(Eigen::Vector3d::Zero());
    touch_s_ = 0;
    return;
  }
  if (mode_ == control::FlightMode::kTakeOff) return;
  if (std::holds_alternative<control::VelocitySetpoint>(setpoint)) mode_ = control::FlightMode::kVelocity;
  if (std::holds_alternative<control::PositionSetpoint>(setpoint)) mode_ = control::FlightMode::kPosition;
  if (std::holds_alternative<control::AttitudeSetpoint>(setpoint)) mode_ = control::FlightMode::kAttitude;
  if (std::holds_alternative<control::RateSetpoint>(setpoint)) mode_ = control::FlightMode::kRates;
}

Actuation EmulatedAutopilot::Step(double dt_s, const SensorReadings& readings) {
  t_s_ += dt_s;
  setpoint_age_s_ += dt_s;
  navigation_.Step(dt_s, t_s_, readings);
  rotor_rad_s_ = readings.rotor_rad_s;
  // Across the thrust an accelerometer feels nothing but the air's drag: leaned against at once, it does not
  // have to become an error of velocity first.
  Eigen::Vector3d drag_B = readings.imu.specific_force_B;
  drag_B.z() = 0;
  Eigen::Vector3d drag_N = navigation_.InUse().X_NB().R * drag_B;
  drag_N.z() = 0;
  drag_N_ += (1 - std::exp(-dt_s / kDragTime_s)) * (drag_N - drag_N_);
  carried_m_s2_ +=
      (1 - std::exp(-dt_s / kCarriedTime_s)) * (-readings.imu.specific_force_B.z() - carried_m_s2_);
  if (mode_ == control::FlightMode::kStopped) return Stopped(aircraft_);
  // A position stands until the next one; all others must be kept up.
  if ((mode_ == control::FlightMode::kVelocity || mode_ == control::FlightMode::kAttitude ||
       mode_ == control::FlightMode::kRates) &&
      setpoint_age_s_ > parameters_.command_timeout_s) {
    mode_ = control::FlightMode::kHold;
    hold_ = {navigation_.InUse().X_NB().p, YawOf(navigation_.InUse().X_NB().R)};
  }
  if (mode_ == control::FlightMode::kRates) return FollowRates(dt_s);
  const Demand demand = Navigate(dt_s);
  if (mode_ == control::FlightMode::kStopped) return Stopped(aircraft_);
  return Stabilise(dt_s, demand);
}

EmulatedAutopilot::Demand EmulatedAutopilot::Navigate(double dt_s) {
  const double yaw = YawOf(navigation_.InUse().X_NB().R);
  const auto turn_to = [&](double wanted) { return kYawGain_per_s * WrapAngle(wanted - yaw_.angle); };
  switch (mode_) {
    case control::FlightMode::kVelocity: {
      const auto& v = std::get<control::VelocitySetpoint>(setpoint_);
      const Demand demand = TrackVelocity(dt_s, HeadingRotation(yaw) * v.v_H, v.yaw_rate);
      WatchTouchDown(dt_s, v.v_H.z());
      return demand;
    }
    case control::FlightMode::kAttitude: {
      const auto& a = std::get<control::AttitudeSetpoint>(setpoint_);
      CommandVelocity(navigation_.InUse().v_N());
      const double limit = Radians(parameters_.stick_limit_deg);
      tilt_limited_ = std::abs(a.roll) * parameters_.roll.gain > limit ||
                      std::abs(a.pitch) * parameters_.pitch.gain > limit;
      return {a.roll, a.pitch, a.yaw_rate, std::clamp(a.thrust, 0.0, 1.0) * MaxThrust_n(aircraft_)};
    }
    case control::FlightMode::kTakeOff: {
      if (!std::visit([&](const auto& s) { return s.Ready(Sensed()); }, stabiliser_)) return {};
      Eigen::Vector3d v = VelocityToward(hold_.p_N);
      v.z() = -kTakeOffClimb_m_s;
      if (navigation_.InUse().X_NB().p.z() < hold_.p_N.z() - kClearOfGround_m) {
        mode_ = control::FlightMode::kPosition;
        if (!std::holds_alternative<control::PositionSetpoint>(setpoint_))
          setpoint_ = control::PositionSetpoint{navigation_.InUse().X_NB().p, hold_.yaw};
      } else {
        v.head<2>().setZero();  // no leaning against skids that still stand
        integral_N_.head<2>().setZero();
      }
      return TrackVelocity(dt_s, v, turn_to(hold_.yaw));
    }
    case control::FlightMode::kPosition: {
      const auto& p = std::get<control::PositionSetpoint>(setpoint_);
      return TrackVelocity(dt_s, VelocityToward(p.p_N), turn_to(p.yaw));
    }
    default:
      return TrackVelocity(dt_s, VelocityToward(hold_.p_N), turn_to(hold_.yaw));
  }
}

Eigen::Vector3d EmulatedAutopilot::VelocityToward(const Eigen::Vector3d& p_N) const {
  return parameters_.position_gain_per_s * (p_N - navigation_.InUse().X_NB().p);
}

void EmulatedAutopilot::CommandVelocity(const Eigen::Vector3d& v_N) {
  v_N_command_ = v_N;
  level_.Reset(v_N.head<2>());
  climb_.Reset(VelocityShaper<1>::Vector(v_N.z()));
  turn_.Reset(VelocityShaper<1>::Vector::Zero());
  north_ = {v_N.x()}, east_ = {v_N.y()};
}

EmulatedAutopilot::Demand EmulatedAutopilot::TrackVelocity(double dt_s, const Eigen::Vector3d& v_N_asked,
                                                           double yaw_rate) {
  Eigen::Vector3d v_N_wanted = v_N_asked;
  v_N_wanted.head<2>() = Limited(v_N_asked.head<2>(), parameters_.speed_limit_m_s);
  v_N_wanted.z() = std::clamp(v_N_asked.z(), -parameters_.climb_limit_m_s, parameters_.climb_limit_m_s);
  using OneAxis = VelocityShaper<1>::Vector;
  const auto level = level_.Step(
      t_s_, dt_s, v_N_wanted.head<2>(),
      {parameters_.level_delay_s, parameters_.acceleration_limit_m_s2, parameters_.level_jerk_limit_m_s3});
  const auto climb = climb_.Step(t_s_, dt_s, OneAxis(v_N_wanted.z()),
                                 {parameters_.climb_delay_s, parameters_.climb_acceleration_limit_m_s2,
                                  parameters_.climb_jerk_limit_m_s3});
  v_N_command_ << level.velocity, climb.velocity;
  Eigen::Vector3d v_N_expected = v_N_command_;
  if (parameters_.velocity_lag_s > 0) {
    const AxisLoop lag{2 / parameters_.velocity_lag_s, 1, 1};
    north_.Step(dt_s, lag, v_N_command_.x());
    east_.Step(dt_s, lag, v_N_command_.y());
    v_N_expected.head<2>() << north_.angle, east_.angle;
  }
  const Eigen::Vector3d error = v_N_expected - navigation_.InUse().v_N();

  Eigen::Vector3d a_N = integral_N_ - drag_N_;
  a_N.head<2>() += parameters_.velocity_gain_per_s * error.head<2>() + level.acceleration;
  a_N.z() += parameters_.climb_gain_per_s * error.z() + climb.acceleration[0];

  Demand demand;
  const control::LevelTilt tilt = control::TiltToAccelerate(
      a_N.head<2>(), YawOf(navigation_.InUse().X_NB().R), Radians(parameters_.tilt_limit_deg));
  tilt_limited_ = tilt.limited;
  // Integrals stand still against a limit, so that nothing has to be unwound when it ends.
  if (!tilt_limited_) integral_N_.head<2>() += dt_s * parameters_.velocity_integral_per_s2 * error.head<2>();
  if (!rotor_limited_ && throttle_down_ >= 1)
    integral_N_.z() += dt_s * parameters_.climb_integral_per_s2 * error.z();
  integral_N_ = integral_N_.cwiseMax(-kIntegralLimit_m_s2).cwiseMin(kIntegralLimit_m_s2);

  demand.roll = tilt.roll / parameters_.roll.gain;  // the loop answers with its gain
  demand.pitch = tilt.pitch / parameters_.pitch.gain;
  demand.yaw_rate = turn_.Step(t_s_, dt_s, OneAxis(yaw_rate), {parameters_.yaw_delay_s}).velocity[0];
  const TaitBryan now = TaitBryanFromRotation(navigation_.InUse().X_NB().R.toRotationMatrix());
  const double upright = std::max(0.5, std::cos(now.roll) * std::cos(now.pitch));
  demand.thrust_n = parameters_.thrust_gain * Mass_kg(aircraft_) * std::max(0.0, kGravity_m_s2 - a_N.z()) /
                    upright * throttle_down_;
  return demand;
}

// Makes the aircraft follow the identified models, whose state is the reference: feed-forward of its
// acceleration, feedback on attitude and rate by the inner loop.
Actuation EmulatedAutopilot::Stabilise(double dt_s, const Demand& demand) {
  const double limit = Radians(mode_ == control::FlightMode::kAttitude ? parameters_.stick_limit_deg
                                                                       : parameters_.tilt_limit_deg);
  const double rate_limit = Radians(parameters_.yaw_rate_limit_deg_s);
  yaw_command_ += dt_s * std::clamp(demand.yaw_rate, -rate_limit, rate_limit);
  roll_.Step(dt_s, parameters_.roll,
             std::clamp(demand.roll, -limit / parameters_.roll.gain, limit / parameters_.roll.gain));
  pitch_.Step(dt_s, parameters_.pitch,
              std::clamp(demand.pitch, -limit / parameters_.pitch.gain, limit / parameters_.pitch.gain));
  yaw_.Step(dt_s, parameters_.yaw, yaw_command_);

  const Eigen::Quaterniond R_NR(
      RotationFromTaitBryan({yaw_.angle, pitch_.angle, roll_.angle}));  // R: the reference
  const Eigen::Vector3d error_B = LogRotation(navigation_.InUse().X_NB().R.conjugate() * R_NR);
  // Rates of the angles as a rate of the body.
  const double sr = std::sin(roll_.angle), cr = std::cos(roll_.angle);
  const double sp = std::sin(pitch_.angle), cp = std::cos(pitch_.angle);
  const Eigen::Vector3d w(roll_.rate - sp * yaw_.rate, cr * pitch_.rate + sr * cp * yaw_.rate,
                          -sr * pitch_.rate + cr * cp * yaw_.rate);
  const Eigen::Vector3d feed(roll_.acceleration, pitch_.acceleration, yaw_.acceleration);
  return Drive(dt_s, {error_B, w, feed, demand.thrust_n});
}

// The inner loop with no attitude to hold. The loops that rest begin from here, when they are next in use.
Actuation EmulatedAutopilot::FollowRates(double dt_s) {
  const auto& wanted = std::get<control::RateSetpoint>(setpoint_);
  const TaitBryan now = TaitBryanFromRotation(navigation_.InUse().X_NB().R.toRotationMatrix());
  roll_ = {now.roll}, pitch_ = {now.pitch}, yaw_ = {now.yaw};
  yaw_command_ = now.yaw;
  CommandVelocity(navigation_.InUse().v_N());
  tilt_limited_ = false;
  const double turn = Radians(parameters_.yaw_rate_limit_deg_s);
  const Eigen::Vector3d most(kRateLimit_rad_s, kRateLimit_rad_s, turn);
  return Drive(dt_s, {Eigen::Vector3d::Zero(), wanted.w_B.cwiseMax(-most).cwiseMin(most),
                      Eigen::Vector3d::Zero(), std::clamp(wanted.thrust, 0.0, 1.0) * MaxThrust_n(aircraft_)});
}

Actuation EmulatedAutopilot::Drive(double dt_s, const AttitudeDemand& demand) {
  return std::visit(
      [&](auto& stabiliser) {
        const Actuation actuation = stabiliser.Step(dt_s, demand, Sensed());
        rotor_limited_ = stabiliser.limited();
        return actuation;
      },
      stabiliser_);
}

SensedMotion EmulatedAutopilot::Sensed() const {
  const StateEstimator& estimate = navigation_.InUse();
  return {estimate.w_B(), -(estimate.X_NB().R.conjugate() * estimate.v_N()).z(), rotor_rad_s_};
}

void EmulatedAutopilot::WatchTouchDown(double dt_s, double descent_wanted) {
  const double sinking = navigation_.InUse().v_N().z();
  const double lag = parameters_.touch_down_lag_m_s;
  const bool stays_behind = lag > 0 && descent_wanted - sinking > lag;
  const bool behind = stays_behind || (descent_wanted > kTouchDescent_m_s && sinking < kTouchStill_m_s);
  const bool upright = (navigation_.InUse().X_NB().R * Eigen::Vector3d::UnitZ()).z() > kTouchUpright;
  if (throttle_down_ >= 1) {
    touch_s_ = behind && upright ? touch_s_ + dt_s : 0;
    if (touch_s_ < kTouchTime_s) return;
  }
  const bool leaves = sinking > kTouchFalling_m_s || descent_wanted <= kTouchDescent_m_s;
  if (carried_m_s2_ < kTouchCarried_m_s2 || !upright ||
      (leaves && !stays_behind)) {  // it falls, or wants to go: in the air
    throttle_down_ = 1;
    touch_s_ = 0;
    return;
  }
  throttle_down_ -= dt_s / kTouchSpool_s;
  if (throttle_down_ < (lag > 0 ? kTouchThrottleMoving : kTouchThrottle)) StopMotors();
}

void EmulatedAutopilot::StopMotors() {
  mode_ = control::FlightMode::kStopped;
  throttle_down_ = 1;
  touch_s_ = 0;
  integral_N_.setZero();
  tilt_limited_ = rotor_limited_ = false;
  std::visit([](auto& s) { s.Stop(); }, stabiliser_);
}

control::VehicleState EmulatedAutopilot::State() const {
  control::VehicleState s;
  s.t_s = t_s_;
  s.p_NB = navigation_.InUse().X_NB().p;
  s.v_N = navigation_.InUse().v_N();
  s.R_NB = navigation_.InUse().X_NB().R;
  s.w_B = navigation_.InUse().w_B();
  s.mode = mode_;
  s.landed = mode_ == control::FlightMode::kStopped;
  s.saturated = tilt_limited_ || rotor_limited_;
  s.aided = navigation_.aided();
  s.R_NB_inertial = navigation_.InertialAttitude();
  return s;
}

}  // namespace kestrel::sim
