// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <variant>

namespace kestrel::control {

// What the autopilot is doing with the aircraft.
enum class FlightMode {
  kStopped,   // motors off, on the ground
  kTakeOff,   // climbing away from the ground
  kVelocity,  // following a VelocitySetpoint
  kPosition,  // following a PositionSetpoint
  kAttitude,  // following an AttitudeSetpoint
  kHold,      // setpoints went stale: holding the place where they did
  kRates,     // following a RateSetpoint
};

// The autopilot's own estimate, never the truth.
struct VehicleState {
  double t_s = 0;                                  // the autopilot's clock
  Eigen::Vector3d p_NB = Eigen::Vector3d::Zero();  // m, from the origin of N: where it was switched on
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();   // m/s
  Eigen::Quaterniond R_NB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  // rad/s, in B
  FlightMode mode = FlightMode::kStopped;
  bool landed = true;      // on the ground, motors stopped by the touch-down logic
  bool saturated = false;  // a motor or the tilt is at its limit
  bool aided = false;      // R_NB is an AttitudeAid's, turned on by the rate gyros
  // By its own sensors alone, whatever it flies by; none: it has no attitude.
  std::optional<Eigen::Quaterniond> R_NB_inertial = Eigen::Quaterniond::Identity();
};

struct VelocitySetpoint {
  Eigen::Vector3d v_H = Eigen::Vector3d::Zero();  // m/s, in the heading frame: forward, right, down
  double yaw_rate = 0;                            // rad/s, clockwise
};

struct PositionSetpoint {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // m
  double yaw = 0;                                 // rad
};

struct AttitudeSetpoint {
  double roll = 0, pitch = 0;  // rad
  double yaw_rate = 0;         // rad/s
  double thrust = 0;           // 0 to 1 of the maximum thrust
};

// Of who closes the loops of attitude, velocity and position himself. Nothing limits the tilt.
struct RateSetpoint {
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  // rad/s, in B
  double thrust = 0;                              // 0 to 1 of the maximum thrust
};

using Setpoint = std::variant<VelocitySetpoint, PositionSetpoint, AttitudeSetpoint, RateSetpoint>;

// An attitude from elsewhere, a camera, at the time of the autopilot's own state.
struct AttitudeAid {
  Eigen::Quaterniond R_NB = Eigen::Quaterniond::Identity();
  double sigma = 0;  // rad, about any axis
};

// An autopilot on the far end of a wire, emulated or real. A setpoint holds until the next one, or until it
// is stale by the autopilot's own time-out: then the aircraft holds its place. On the ground, a position
// above it is the command to take off.
class Autopilot {
 public:
  virtual ~Autopilot() = default;
  virtual VehicleState State() const = 0;
  virtual void Send(const Setpoint& setpoint) = 0;
  // The autopilot flies by this attitude in place of its own, until it is stale like a setpoint.
  virtual void Aid(const AttitudeAid& aid) = 0;
};

const char* NameOf(FlightMode mode);

// Whether every number of it is one; of a state, all but what its own sensors alone would say.
bool Finite(const VehicleState& state);
bool Finite(const Setpoint& setpoint);

// Farther from the origin of N, faster, or turning faster, no aircraft of ours is: such numbers are a fault
// of the autopilot or of the wire.
inline constexpr double kSanePosition_m = 100e3, kSaneSpeed_m_s = 200, kSaneRate_rad_s = 50;

// Whether a state is finite, its attitude a rotation, and the rest within these bounds.
bool Sane(const VehicleState& state);

}  // namespace kestrel::control
