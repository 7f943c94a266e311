// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/yaml/fields.h"
#include "control/autopilot.h"

// Velocity and position by an autopilot that is given an attitude and a thrust: what stands between them.
// Pure; called with each new state of the vehicle, it takes its time step from their times.
//
//   a = k_v (v_r - v) + dv*/dt + integral of k_i (v_r - v)
//
// where v* is the command, slewed, and v_r is v* as an aircraft without disturbance follows it, late by the
// autopilot's answer and the line: what is merely on its way is not corrected. The level part leans the
// aircraft, g tan(tilt) = a, the vertical part goes to the thrust, hover_thrust (g - a_z) / g / cos(tilt).
// The integral is what wind and weight ask for: it also makes up for a hover_thrust that is not quite right,
// within 0.4 to 1.6 times the one that is given.
namespace kestrel::control {

struct VelocityLoopOptions {
  double hover_thrust = 0.45;
  double roll_gain = 0.80, pitch_gain = 0.84;
  double speed_limit_m_s = 3, climb_limit_m_s = 1.5, acceleration_limit_m_s2 = 2;
  double tilt_limit_deg = 20, yaw_rate_limit_deg_s = 60;
  double thrust_min = 0.2, thrust_max = 0.8;
  double velocity_gain_per_s = 2.0, velocity_integral_per_s2 = 0.8;
  double climb_gain_per_s = 2.5, climb_integral_per_s2 = 1.5;
  double position_gain_per_s = 0.7, yaw_gain_per_s = 1.0;
  double level_delay_s = 0.3, climb_delay_s = 0.15;
};

inline void Fields(FieldVisitor& v, VelocityLoopOptions& o) {
  v({"hover_thrust", "thrust that hovers in still air, as a share of full thrust"}, o.hover_thrust, 0.05,
    0.95);
  v({"roll_gain", "steady roll that the autopilot gives, over the roll that is asked of it"}, o.roll_gain,
    0.1, 2.0);
  v({"pitch_gain", "steady pitch that the autopilot gives, over the pitch that is asked of it"}, o.pitch_gain,
    0.1, 2.0);
  v({"speed_limit_m_s", "maximum horizontal speed that is commanded"}, o.speed_limit_m_s, 0.1, 30.0);
  v({"climb_limit_m_s", "maximum vertical speed that is commanded, up or down"}, o.climb_limit_m_s, 0.1,
    10.0);
  v({"acceleration_limit_m_s2", "maximum rate at which the velocity command changes"},
    o.acceleration_limit_m_s2, 0.1, 10.0);
  v({"tilt_limit_deg", "maximum tilt that is flown to accelerate"}, o.tilt_limit_deg, 1.0, 45.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate that is commanded"}, o.yaw_rate_limit_deg_s, 1.0, 200.0);
  v(Renamed("thrust_min", "thrust_least", "minimum thrust that is commanded, as a share of full thrust"),
    o.thrust_min, 0.0, 1.0);
  v(Renamed("thrust_max", "thrust_most", "maximum thrust that is commanded, as a share of full thrust"),
    o.thrust_max, 0.0, 1.0);
  v({"velocity_gain_per_s", "proportional gain from horizontal velocity error to acceleration"},
    o.velocity_gain_per_s, 0.0, 20.0);
  v({"velocity_integral_per_s2", "integral gain from horizontal velocity error to acceleration"},
    o.velocity_integral_per_s2, 0.0, 20.0);
  v({"climb_gain_per_s", "proportional gain from vertical velocity error to acceleration"},
    o.climb_gain_per_s, 0.0, 20.0);
  v({"climb_integral_per_s2", "integral gain from vertical velocity error to acceleration"},
    o.climb_integral_per_s2, 0.0, 20.0);
  v({"position_gain_per_s", "proportional gain from position error to velocity"}, o.position_gain_per_s, 0.0,
    5.0);
  v({"yaw_gain_per_s", "proportional gain from heading error to yaw rate"}, o.yaw_gain_per_s, 0.0, 5.0);
  v({"level_delay_s",
     "delay from a state to the horizontal acceleration that answers it: link, attitude loop, motors"},
    o.level_delay_s, 0.0, 2.0);
  v({"climb_delay_s", "delay from a state to the vertical acceleration that answers it: link and motors"},
    o.climb_delay_s, 0.0, 2.0);
}

struct VelocityLoopState {
  std::optional<double> t_s;                              // of the vehicle's state at the last step
  Eigen::Vector3d command_N = Eigen::Vector3d::Zero();    // m/s, slewed
  Eigen::Vector3d reference_N = Eigen::Vector3d::Zero();  // m/s, what is expected of it by now
  Eigen::Vector3d integral_N = Eigen::Vector3d::Zero();   // m/s^2
};

struct VelocityLoopOutput {
  AttitudeSetpoint setpoint;
  bool limited = false;     // the tilt or the thrust would be more
  VelocityLoopState state;  // for the next call
};

// After a pause of half a second or more, and at first, the command begins at the velocity that there is; the
// integral is kept. A setpoint or vehicle state that is not finite is the caller's to refuse.
VelocityLoopOutput StepVelocityLoop(const VelocitySetpoint& wanted, const VehicleState& vehicle,
                                    const VelocityLoopState& before, const VelocityLoopOptions& options);

// The velocity that a position asks for, within the limits of speed, climb and yaw rate.
VelocitySetpoint VelocityToward(const PositionSetpoint& wanted, const VehicleState& vehicle,
                                const VelocityLoopOptions& options);

// Whether the aircraft has touched down, which an autopilot that flies attitudes does not tell: it was asked
// to sink and did not for 0.8 s (moments in which it seems to count back twice); then its thrust is taken
// away bit by bit, and if even that does not make it sink it stands on the ground.
struct TouchDown {
  double still_s = 0;
  double throttle = 1;  // to be multiplied with the thrust
  bool down = false;
};
TouchDown WatchTouchDown(double dt_s, double asked_m_s, double sinking_m_s, const TouchDown& before);

}  // namespace kestrel::control
