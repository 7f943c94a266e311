// SPDX-License-Identifier: Apache-2.0
#include "control/autopilot.h"

#include <cmath>

namespace kestrel::control {

const char* NameOf(FlightMode mode) {
  switch (mode) {
    case FlightMode::kStopped:
      return "stopped";
    case FlightMode::kTakeOff:
      return "take-off";
    case FlightMode::kVelocity:
      return "velocity";
    case FlightMode::kPosition:
      return "position";
    case FlightMode::kAttitude:
      return "attitude";
    case FlightMode::kHold:
      return "hold";
    case FlightMode::kRates:
      return "rates";
  }
  return "?";
}

bool Finite(const VehicleState& s) {
  return std::isfinite(s.t_s) && s.p_NB.allFinite() && s.v_N.allFinite() && s.R_NB.coeffs().allFinite() &&
         s.w_B.allFinite();
}

bool Sane(const VehicleState& s) {
  constexpr double kUnit = 0.01;  // what rounding on a wire leaves of a unit quaternion
  return Finite(s) && std::abs(s.R_NB.norm() - 1) <= kUnit && s.p_NB.norm() <= kSanePosition_m &&
         s.v_N.norm() <= kSaneSpeed_m_s && s.w_B.norm() <= kSaneRate_rad_s;
}

bool Finite(const Setpoint& setpoint) {
  struct Visitor {
    bool operator()(const VelocitySetpoint& s) const {
      return s.v_H.allFinite() && std::isfinite(s.yaw_rate);
    }
    bool operator()(const PositionSetpoint& s) const { return s.p_N.allFinite() && std::isfinite(s.yaw); }
    bool operator()(const AttitudeSetpoint& s) const {
      return std::isfinite(s.roll) && std::isfinite(s.pitch) && std::isfinite(s.yaw_rate) &&
             std::isfinite(s.thrust);
    }
    bool operator()(const RateSetpoint& s) const { return s.w_B.allFinite() && std::isfinite(s.thrust); }
  };
  return std::visit(Visitor{}, setpoint);
}

}  // namespace kestrel::control
