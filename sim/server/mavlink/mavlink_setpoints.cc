// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_setpoints.h"

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;

constexpr double kYawGain_per_s = 1;
// MAV_FRAME
constexpr int kLocalNed = 1, kLocalOffset = 7, kBodyNed = 8, kBodyOffset = 9;
// POSITION_TARGET_TYPEMASK: what to leave out
constexpr unsigned kPosition = 7, kVelocity = 7 << 3, kAcceleration = 7 << 6, kForce = 512, kYaw = 1024,
                   kYawRate = 2048;
// ATTITUDE_TARGET_TYPEMASK: the same
constexpr unsigned kRates = 7, kRollAndPitchRate = 3, kAttitudeYawRate = 4, kThrustBody = 32, kThrottle = 64,
                   kAttitude = 128;

bool None(unsigned mask, unsigned bits) { return (mask & bits) == 0; }
bool All(unsigned mask, unsigned bits) { return (mask & bits) == bits; }

}  // namespace

std::optional<MavlinkSetpoint> MavlinkSetpoint::Read(const SetPositionTargetLocalNed& m,
                                                     const control::VehicleState& now,
                                                     const Dialect& dialect) {
  const bool px4 = &dialect == &kPx4;
  const unsigned mask = m.type_mask;
  const int frame = m.coordinate_frame;
  if (frame != kLocalNed && frame != kBodyNed && (px4 || (frame != kLocalOffset && frame != kBodyOffset)))
    return std::nullopt;
  if (!All(mask, kAcceleration) || (mask & kForce) != 0) return std::nullopt;
  const bool has_yaw = None(mask, kYaw), has_yaw_rate = None(mask, kYawRate);
  const Eigen::Vector3d p(m.x, m.y, m.z), v(m.vx, m.vy, m.vz);
  const Eigen::Quaterniond R_NH = HeadingRotation(YawOf(now.R_NB));
  MavlinkSetpoint read;
  // PX4 takes no position in its body frame; a velocity beside a position is feed-forward.
  if (None(mask, kPosition) && !(px4 && frame == kBodyNed)) {
    if (has_yaw_rate) return std::nullopt;
    control::PositionSetpoint position{p, has_yaw ? m.yaw : YawOf(now.R_NB)};
    if (frame == kLocalOffset) position.p_N = now.p_NB + p;
    if (frame == kBodyOffset) position.p_N = now.p_NB + R_NH * p;
    read.setpoint_ = position;
  } else if (None(mask, kVelocity) && (All(mask, kPosition) || (px4 && frame == kBodyNed))) {
    read.setpoint_ = control::VelocitySetpoint{v, has_yaw_rate ? m.yaw_rate : 0.0};
    if (frame == kLocalNed || frame == kLocalOffset) read.v_N_ = v;
    if (has_yaw) read.yaw_ = m.yaw;
  } else {
    return std::nullopt;
  }
  if ((read.yaw_ && !std::isfinite(*read.yaw_)) || !control::Finite(read.setpoint_)) return std::nullopt;
  return read;
}

std::optional<MavlinkSetpoint> MavlinkSetpoint::Read(const SetAttitudeTarget& m, const Dialect& dialect) {
  const unsigned mask = m.type_mask;
  if ((mask & (kThrottle | kThrustBody)) != 0) return std::nullopt;
  if (All(mask, kAttitude)) {  // all three rates are followed
    MavlinkSetpoint read;
    read.setpoint_ = control::RateSetpoint{{m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate}, m.thrust};
    if (!None(mask, kRates) || !control::Finite(read.setpoint_)) return std::nullopt;
    return read;
  }
  // PX4 follows rates of roll and pitch in place of the attitude; ArduPilot takes all three, or none.
  const bool right =
      &dialect == &kPx4 ? (mask & kRollAndPitchRate) != 0 : None(mask, kRates) || All(mask, kRates);
  if (!right) return std::nullopt;
  const Eigen::Quaterniond q(m.q[0], m.q[1], m.q[2], m.q[3]);
  if (!(std::abs(q.norm() - 1) < 1e-3)) return std::nullopt;
  const TaitBryan angles = TaitBryanFromRotation(q.normalized().toRotationMatrix());
  double yaw_rate = 0;
  if (None(mask, kAttitudeYawRate)) {
    const Eigen::Vector3d w_B(m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate);
    yaw_rate = &dialect == &kPx4 ? w_B.z() : (q * w_B).z();
  }
  MavlinkSetpoint read;
  read.setpoint_ = control::AttitudeSetpoint{angles.roll, angles.pitch, yaw_rate, m.thrust};
  read.yaw_ = angles.yaw;
  if (!control::Finite(read.setpoint_)) return std::nullopt;
  return read;
}

control::Setpoint MavlinkSetpoint::At(const control::VehicleState& now) const {
  control::Setpoint setpoint = setpoint_;
  const double yaw = YawOf(now.R_NB);
  const double turn = yaw_ ? kYawGain_per_s * WrapAngle(*yaw_ - yaw) : 0;
  if (auto* velocity = std::get_if<control::VelocitySetpoint>(&setpoint)) {
    if (v_N_) velocity->v_H = HeadingRotation(yaw).conjugate() * *v_N_;
    velocity->yaw_rate += turn;
  }
  if (auto* attitude = std::get_if<control::AttitudeSetpoint>(&setpoint)) attitude->yaw_rate += turn;
  return setpoint;
}

}  // namespace kestrel::sim
