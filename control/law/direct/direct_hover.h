// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "base/yaml/fields.h"
#include "control/autopilot.h"

// Direct visual servoing, thesis 5.2.2 (Sanderson and Weiss): what the camera sees becomes rates and thrust,
// and the law keeps the aircraft in the air by itself. In place of the autopilot's loops of position, velocity
// and attitude stand
//
//   a = -k_p p - k_v v - d,   z_B -> -(a - g) / |a - g|,   w = k_a (the turn to there),   thrust = |a - g|
//
// with the offset p from the goal, its derivative v and the disturbance d that HoverObserver finds.
namespace kestrel::control {

struct DirectGains {
  double position_per_s2 = 5;
  double velocity_per_s = 4;
  double attitude_per_s = 9;
  double yaw_per_s = 1.5;
  double offset_limit_m = 0.5;
  double acceleration_limit_m_s2 = 4;
  double rate_limit_deg_s = 180, yaw_rate_limit_deg_s = 60;
  double hover_thrust = 0.454;
};

inline void Fields(FieldVisitor& v, DirectGains& g) {
  v({"position_per_s2", "gain from offset to acceleration"}, g.position_per_s2, 0.01, 200.0);
  v({"velocity_per_s", "gain from velocity to acceleration"}, g.velocity_per_s, 0.01, 50.0);
  v({"attitude_per_s", "gain from error of attitude to rate"}, g.attitude_per_s, 0.1, 50.0);
  v({"yaw_per_s", "gain from error of heading to yaw rate"}, g.yaw_per_s, 0.0, 20.0);
  v({"offset_limit_m",
     "offset beyond which no more is asked for, level and vertical each: it limits the speed of the "
     "approach"},
    g.offset_limit_m, 0.01, 10.0);
  v({"acceleration_limit_m_s2", "maximum acceleration that is asked for, level and vertical each"},
    g.acceleration_limit_m_s2, 0.1, 8.0);
  v({"rate_limit_deg_s", "maximum rate of roll and pitch"}, g.rate_limit_deg_s, 5.0, 340.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate"}, g.yaw_rate_limit_deg_s, 1.0, 180.0);
  v({"hover_thrust", "thrust that hovers in still air, as a share of full thrust"}, g.hover_thrust, 0.05,
    0.95);
}

struct DirectError {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // offset from the goal, m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d d_N = Eigen::Vector3d::Zero();  // m/s^2
  double yaw = 0;                                 // to be turned clockwise yet, rad
};

// R_NB: any N with z down; p, v and d are in the same.
RateSetpoint DirectHover(const DirectError& error, const Eigen::Quaterniond& R_NB, const DirectGains& gains);

// The acceleration over ground that a thrust gives at an attitude, by hover_thrust.
Eigen::Vector3d ThrustAcceleration(double thrust, const Eigen::Quaterniond& R_NB, const DirectGains& gains);

}  // namespace kestrel::control
