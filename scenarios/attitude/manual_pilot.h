// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "base/yaml/fields.h"
#include "control/autopilot.h"

namespace kestrel::scenarios {

// How hard a safety pilot throws the aircraft about.
struct ManoeuvreParameters {
  double tilt_deg = 30;
  double period_s = 3.5;
  double yaw_rate_deg_s = 40;
  double yaw_period_s = 40;
  double net_turn_deg_s = 6;
  double height_m = 60;
  double height_swing_m = 5;
};

inline void Fields(FieldVisitor& v, ManoeuvreParameters& p) {
  v({"tilt_deg", "maximum roll and pitch of the manoeuvres"}, p.tilt_deg, 0.0, 40.0);
  v({"period_s", "mean period of the swings of roll and pitch"}, p.period_s, 1.0, 60.0);
  v({"yaw_rate_deg_s", "amplitude of the yaw rate, which swings to the left and right"}, p.yaw_rate_deg_s,
    0.0, 90.0);
  v({"yaw_period_s", "mean period of the swings of the yaw rate"}, p.yaw_period_s, 5.0, 600.0);
  v({"net_turn_deg_s", "steady yaw rate on top of the swings, clockwise positive"}, p.net_turn_deg_s, -45.0,
    45.0);
  v({"height_m", "mean height above the autopilot's local origin"}, p.height_m, 1.0, 500.0);
  v({"height_swing_m",
     "amplitude of the climbs and descents about height_m, with a period of about a minute"},
    p.height_swing_m, 0.0, 100.0);
}

// A pilot at the sticks: attitude and thrust. Swings of roll and pitch that come and go, turns both ways, and
// as much care as keeps the aircraft near the place and the height that it should be at.
class ManualPilot {
 public:
  ManualPilot(const ManoeuvreParameters& manoeuvres, std::uint64_t seed);

  // home_N: over which it stays, m; the height is that of the manoeuvres.
  control::AttitudeSetpoint Fly(const control::VehicleState& state, const Eigen::Vector3d& home_N);

 private:
  struct Swing {
    double rate, phase;  // rad/s, rad
    double At(double t_s) const;
  };
  ManoeuvreParameters p_;
  std::array<Swing, 4> roll_, pitch_;  // two tones, and how they come and go
  Swing yaw_, climb_;
  double hover_thrust_ = 0.5;  // learnt
  double last_s_ = -1;
};

}  // namespace kestrel::scenarios
