// SPDX-License-Identifier: Apache-2.0
#include "control/safety/safety.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

Hazard Judge(const Situation& now, const SafetyLimits& l) {
  if (!now.pilot_allows) return Hazard::kPilot;
  if (!now.state_age_s || !(*now.state_age_s <= l.state_s) || !Sane(now.state)) return Hazard::kStateLost;
  if (now.wanted && !Finite(*now.wanted)) return Hazard::kNotFinite;
  if (!now.image_age_s || !(*now.image_age_s <= l.image_s)) return Hazard::kImageStale;
  if (!(now.target_lost_s <= l.target_s)) return Hazard::kTargetLost;
  const Eigen::Vector3d from_start = now.state.p_NB - now.start_N;
  if (from_start.head<2>().norm() > l.radius_m) return Hazard::kOutside;
  if (-from_start.z() > l.height_m) return Hazard::kTooHigh;
  return now.wanted ? Hazard::kNone : Hazard::kNoSetpoint;
}

// To a largest magnitude; whether it had to be.
bool Limit(double& value, double most) {
  const double before = value;
  value = std::clamp(value, -most, most);
  return value != before;
}

struct Limiter {
  const Situation& now;
  const SafetyLimits& l;

  bool operator()(VelocitySetpoint& s) const {
    bool limited = Limit(s.v_H.z(), l.climb_m_s);
    if (const double speed = s.v_H.head<2>().norm(); speed > l.speed_m_s) {
      s.v_H.head<2>() *= l.speed_m_s / speed;
      limited = true;
    }
    return Limit(s.yaw_rate, Radians(l.yaw_rate_deg_s)) || limited;
  }
  bool operator()(PositionSetpoint& s) const {
    bool limited = false;
    Eigen::Vector3d from_start = s.p_N - now.start_N;
    if (const double distance = from_start.head<2>().norm(); distance > l.radius_m) {
      from_start.head<2>() *= l.radius_m / distance;
      limited = true;
    }
    if (-from_start.z() > l.height_m) from_start.z() = -l.height_m, limited = true;
    if (limited) s.p_N = now.start_N + from_start;
    return limited;
  }
  bool operator()(AttitudeSetpoint& s) const {
    // The tilt is that of the thrust: cos(tilt) = cos(roll) cos(pitch).
    bool limited = Limit(s.roll, Radians(l.tilt_deg));
    limited =
        Limit(s.pitch, std::acos(std::min(1.0, std::cos(Radians(l.tilt_deg)) / std::cos(s.roll)))) || limited;
    limited = Limit(s.yaw_rate, Radians(l.yaw_rate_deg_s)) || limited;
    const double thrust = s.thrust;
    s.thrust = std::clamp(s.thrust, l.thrust_min, std::max(l.thrust_min, l.thrust_max));
    return limited || s.thrust != thrust;
  }
  // Rates are let through up to the tilt that is allowed; from there on only those that lead back.
  bool operator()(RateSetpoint& s) const {
    bool limited = Limit(s.w_B.z(), Radians(l.yaw_rate_deg_s));
    const Eigen::Vector3d down_B = now.state.R_NB.conjugate() * Eigen::Vector3d::UnitZ();
    const bool leads_on = s.w_B.cross(Eigen::Vector3d::UnitZ()).dot(down_B) < 0;
    if (down_B.z() < std::cos(Radians(l.tilt_deg)) && leads_on) {
      s.w_B.head<2>().setZero();
      limited = true;
    }
    const double thrust = s.thrust;
    s.thrust = std::clamp(s.thrust, l.thrust_min, std::max(l.thrust_min, l.thrust_max));
    return limited || s.thrust != thrust;
  }
};

// What was asked for, but down: a climb becomes a slow descent, the rest stays.
Setpoint Descending(const Situation& now, const SafetyLimits& l) {
  VelocitySetpoint down;
  if (now.wanted)
    if (const auto* velocity = std::get_if<VelocitySetpoint>(&*now.wanted)) down = *velocity;
  down.v_H.z() = std::max(down.v_H.z(), l.slow_m_s);
  return down;
}

Setpoint Returning(const Situation& now, const SafetyLimits& l) {
  Eigen::Vector3d back = now.start_N - now.state.p_NB;
  back.z() = 0;
  VelocitySetpoint setpoint;
  setpoint.v_H = HeadingRotation(YawOf(now.state.R_NB)).conjugate() * (l.slow_m_s * back.normalized());
  return setpoint;
}

}  // namespace

SafeCommand MakeSafe(const Situation& now, const SafetyState& before, const SafetyLimits& l) {
  SafeCommand command;
  const Hazard hazard = Judge(now, l);
  command.state = hazard == before.hazard ? before : SafetyState{hazard, now.t_s};
  const ReactionRow& row = *std::find_if(kReactions.begin(), kReactions.end(),
                                         [&](const ReactionRow& r) { return r.hazard == hazard; });
  command.reaction = now.t_s - command.state.since_s < l.patience_s ? row.first : row.later;
  switch (command.reaction) {
    case Reaction::kSilence:
      return command;
    case Reaction::kHold:
      command.setpoint = VelocitySetpoint{};
      break;
    case Reaction::kSink:
      command.setpoint = VelocitySetpoint{{0, 0, l.slow_m_s}, 0};
      break;
    case Reaction::kReturn:
      command.setpoint = Returning(now, l);
      break;
    case Reaction::kDescend:
      command.setpoint = Descending(now, l);
      break;
    case Reaction::kFly:
      command.setpoint = now.wanted;
      break;
  }
  command.limited = std::visit(Limiter{now, l}, *command.setpoint);
  return command;
}

const char* NameOf(Hazard hazard) {
  switch (hazard) {
    case Hazard::kPilot:
      return "pilot";
    case Hazard::kStateLost:
      return "state lost";
    case Hazard::kNotFinite:
      return "not finite";
    case Hazard::kImageStale:
      return "image stale";
    case Hazard::kTargetLost:
      return "target lost";
    case Hazard::kOutside:
      return "outside";
    case Hazard::kTooHigh:
      return "too high";
    case Hazard::kNoSetpoint:
      return "no setpoint";
    case Hazard::kNone:
      return "none";
  }
  return "?";
}

const char* NameOf(Reaction reaction) {
  switch (reaction) {
    case Reaction::kSilence:
      return "silence";
    case Reaction::kHold:
      return "hold";
    case Reaction::kSink:
      return "sink";
    case Reaction::kReturn:
      return "return";
    case Reaction::kDescend:
      return "descend";
    case Reaction::kFly:
      return "fly";
  }
  return "?";
}

}  // namespace kestrel::control
