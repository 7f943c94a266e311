// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "sim/aircraft/airframe.h"
#include "sim/autopilot/navigation.h"
#include "sim/autopilot/velocity_shaper.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// A closed attitude axis as identified: angle = gain w^2 / (s^2 + 2 d w s + w^2) command.
struct AxisLoop {
  double natural_frequency_rad_s = 7.07;
  double damping = 0.72;
  double gain = 1;
};

struct AutopilotParameters {
  AxisLoop roll{7.07, 0.72, 0.80}, pitch{7.07, 0.76, 0.84}, yaw{5.0, 0.95, 1.0};
  double tilt_limit_deg = 25;
  double stick_limit_deg = 45;  // the same for attitudes that are asked for themselves
  double yaw_rate_limit_deg_s = 90;
  double speed_limit_m_s = 3;
  double climb_limit_m_s = 2;
  double acceleration_limit_m_s2 = 2;
  double velocity_gain_per_s = 2.6;
  double velocity_integral_per_s2 = 1.2;
  // By how much the level velocity expected is later than the one asked for, as tilting takes its time: what
  // the feed-forward of acceleration will yet bring is then no error that would be made good twice. 0: none.
  double velocity_lag_s = 0;
  double climb_gain_per_s = 3.5;
  double climb_integral_per_s2 = 2.0;
  // How the velocities that are asked for are shaped before they are followed. The dead times are of what is
  // late by as much whatever it is asked for. A limit of acceleration makes it late by how much that asks for:
  // ArduCopter by its defaults takes 1 m/s^2 up and down (WPNAV_ACCEL_Z), and follows 0.85 s late.
  double level_delay_s = 0, climb_delay_s = 0, yaw_delay_s = 0;
  double level_jerk_limit_m_s3 = 0;          // 0: none
  double climb_acceleration_limit_m_s2 = 0;  // 0: none
  double climb_jerk_limit_m_s3 = 0;          // 0: none; of use with a limit of the acceleration alone
  // Thrust that comes over the thrust that is asked for: of an autopilot that takes the aircraft for another
  // mass, or its rotors for another curve of thrust.
  double thrust_gain = 1;
  double position_gain_per_s = 0.9;
  double command_timeout_s = 0.5;
  // Of a touch-down on what moves: by how much less than asked for the aircraft sinks once it stands. 0: it stands
  // where it does not sink at all.
  double touch_down_lag_m_s = 0;
};

inline void Fields(FieldVisitor& v, AxisLoop& a) {
  v({"natural_frequency_rad_s", "natural frequency of the closed attitude loop"}, a.natural_frequency_rad_s,
    0.5, 30.0);
  v({"damping", "damping ratio of the closed attitude loop"}, a.damping, 0.1, 3.0);
  v({"gain", "static gain: angle over commanded angle"}, a.gain, 0.1, 2.0);
}

inline void Fields(FieldVisitor& v, AutopilotParameters& p) {
  v({"roll", "closed loop of roll, as identified"}, p.roll);
  v({"pitch", "closed loop of pitch, as identified"}, p.pitch);
  v({"yaw", "closed loop of yaw, as identified"}, p.yaw);
  v({"tilt_limit_deg", "maximum tilt that the velocity loop asks for"}, p.tilt_limit_deg, 1.0, 60.0);
  v({"stick_limit_deg", "maximum tilt where an attitude is asked for itself"}, p.stick_limit_deg, 1.0, 60.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate"}, p.yaw_rate_limit_deg_s, 1.0, 360.0);
  v({"speed_limit_m_s", "maximum horizontal speed"}, p.speed_limit_m_s, 0.1, 30.0);
  v({"climb_limit_m_s", "maximum vertical speed"}, p.climb_limit_m_s, 0.1, 10.0);
  v({"acceleration_limit_m_s2", "maximum horizontal acceleration with which the velocity setpoint is slewed"},
    p.acceleration_limit_m_s2, 0.1, 10.0);
  v({"velocity_gain_per_s", "proportional gain of the horizontal velocity loop"}, p.velocity_gain_per_s, 0.0,
    20.0);
  v({"velocity_integral_per_s2", "integral gain of the horizontal velocity loop"}, p.velocity_integral_per_s2,
    0.0, 20.0);
  v({"velocity_lag_s",
     "by how much later than asked for the loop expects the horizontal velocity; 0: it does not"},
    p.velocity_lag_s, 0.0, 2.0);
  v({"climb_gain_per_s", "proportional gain of the vertical velocity loop"}, p.climb_gain_per_s, 0.0, 20.0);
  v({"climb_integral_per_s2", "integral gain of the vertical velocity loop"}, p.climb_integral_per_s2, 0.0,
    20.0);
  v({"level_delay_s", "dead time until a horizontal velocity that is asked for is followed"}, p.level_delay_s,
    0.0, 3.0);
  v({"climb_delay_s", "dead time until a vertical velocity that is asked for is followed"}, p.climb_delay_s,
    0.0, 3.0);
  v({"yaw_delay_s", "dead time until a yaw rate that is asked for is followed"}, p.yaw_delay_s, 0.0, 3.0);
  v({"level_jerk_limit_m_s3", "maximum jerk with which the horizontal velocity setpoint is shaped; 0: none"},
    p.level_jerk_limit_m_s3, 0.0, 100.0);
  v({"climb_acceleration_limit_m_s2",
     "maximum vertical acceleration with which the velocity setpoint is slewed; 0: none"},
    p.climb_acceleration_limit_m_s2, 0.0, 20.0);
  v({"climb_jerk_limit_m_s3",
     "maximum jerk of that, with a limit of the vertical acceleration alone; 0: none"},
    p.climb_jerk_limit_m_s3, 0.0, 100.0);
  v({"thrust_gain",
     "thrust that comes over the thrust that is asked for: mass and thrust curve as the autopilot has them, "
     "over the true ones"},
    p.thrust_gain, 0.4, 2.0);
  v({"position_gain_per_s", "proportional gain of position hold: velocity over position error"},
    p.position_gain_per_s, 0.0, 5.0);
  v({"touch_down_lag_m_s",
     "how far the sink rate stays behind the one asked for once the aircraft stands, on a deck that heaves; "
     "0: "
     "it stands where it does not sink"},
    p.touch_down_lag_m_s, 0.0, 3.0);
  v({"command_timeout_s", "silence of setpoints after which it holds its place"}, p.command_timeout_s, 0.05,
    10.0);
}

// An AscTec-like low-level autopilot: an attitude loop with the identified closed-loop dynamics, velocity and
// height loops above it, position hold above those, and below it rates, for who closes all these loops
// himself; limits, take-off, stopping the motors on touch-down, and
// a hold when setpoints go stale. It knows nothing but its sensors, and an attitude that it may be sent.
class EmulatedAutopilot {
 public:
  // Switched on at the pose; flying: in the air, motors on, holding that place, otherwise on the ground.
  EmulatedAutopilot(const AutopilotParameters& parameters, const SensorParameters& sensors,
                    const AirframeParameters& aircraft, const Pose& X_NB, bool flying,
                    const Eigen::Vector3d& gyro_bias);

  void Send(const control::Setpoint& setpoint);
  void Aid(const control::AttitudeAid& aid) { navigation_.Aid(aid); }
  void ChangeFaults(std::vector<AttitudeFault> faults) { navigation_.ChangeFaults(std::move(faults)); }
  // Advances by one step of the simulation; returns what the aircraft's rotors are to do.
  Actuation Step(double dt_s, const SensorReadings& readings);

  control::VehicleState State() const;
  NavigationHealth Health() const { return navigation_.Health(); }
  double t_s() const { return t_s_; }
  void SetClock(double t_s) { t_s_ = t_s; }

 private:
  struct Demand {                              // what the outer loops ask of the inner
    double roll = 0, pitch = 0, yaw_rate = 0;  // rad, rad, rad/s
    double thrust_n = 0;
  };
  struct AxisState {
    double angle = 0, rate = 0, acceleration = 0;
    void Step(double dt_s, const AxisLoop& loop, double command);
  };

  Demand Navigate(double dt_s);
  Demand TrackVelocity(double dt_s, const Eigen::Vector3d& v_N_wanted, double yaw_rate);
  Eigen::Vector3d VelocityToward(const Eigen::Vector3d& p_N) const;
  void CommandVelocity(const Eigen::Vector3d& v_N);  // without slewing
  Actuation Stabilise(double dt_s, const Demand& demand);
  Actuation FollowRates(double dt_s);
  Actuation Drive(double dt_s, const AttitudeDemand& demand);  // by the inner loop
  SensedMotion Sensed() const;
  void WatchTouchDown(double dt_s, double descent_wanted);
  void StopMotors();

  AutopilotParameters parameters_;
  AirframeParameters aircraft_;
  Stabiliser stabiliser_;
  Navigation navigation_;
  double t_s_ = 0;
  double rotor_rad_s_ = 0;  // of the tachometer

  control::FlightMode mode_;
  control::Setpoint setpoint_;
  double setpoint_age_s_ = 0;
  control::PositionSetpoint hold_;

  AxisState roll_, pitch_, yaw_;
  double yaw_command_ = 0;
  Eigen::Vector3d v_N_command_ = Eigen::Vector3d::Zero();  // slewed by the acceleration limit
  AxisState north_, east_;                                 // that, later by velocity_lag_s
  VelocityShaper<2> level_;
  VelocityShaper<1> climb_, turn_;
  Eigen::Vector3d integral_N_ = Eigen::Vector3d::Zero();  // m/s^2: what wind and weight ask for
  Eigen::Vector3d drag_N_ = Eigen::Vector3d::Zero();      // felt by the accelerometers, m/s^2, level
  double carried_m_s2_ = 0;   // specific force upwards, smoothed: what carries the aircraft
  double touch_s_ = 0;        // how long it has looked like standing on the ground
  double throttle_down_ = 1;  // share of the thrust left while making sure of that
  bool tilt_limited_ = false, rotor_limited_ = false;
};

}  // namespace kestrel::sim
