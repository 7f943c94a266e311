// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "control/autopilot.h"
#include "geometry/pose.h"

// Position-based visual servoing, thesis 5.2.3 and 5.3: dynamic look-and-move, figure 5.4.
namespace kestrel {

// Velocity of a frame C, expressed in C: m/s and rad/s.
struct Twist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
};

// The decoupled law, eq. (5.13): v = -lambda R_DC^T t_DC, w = -lambda theta u, where X_DC is the pose of the
// moving frame C in the desired frame D. Under it the position error falls along a straight line and the
// rotation about a fixed axis, both as exp(-lambda t).
Twist PbvsTwist(const Pose& X_DC, double lambda_per_s);

struct ServoGains {
  double lambda_per_s = 1.1;  // horizontal
  double lambda_vertical_per_s = 1.2;
  double lambda_yaw_per_s = 0.8;
  double speed_limit_m_s = 1.5;
  double climb_limit_m_s = 0.8;
  double yaw_rate_limit_deg_s = 40;
};

template <class Visitor>
void Fields(Visitor& v, ServoGains& g) {
  v("lambda_per_s", g.lambda_per_s, 0.0, 5.0);
  v("lambda_vertical_per_s", g.lambda_vertical_per_s, 0.0, 5.0);
  v("lambda_yaw_per_s", g.lambda_yaw_per_s, 0.0, 5.0);
  v("speed_limit_m_s", g.speed_limit_m_s, 0.05, 10.0);
  v("climb_limit_m_s", g.climb_limit_m_s, 0.05, 5.0);
  v("yaw_rate_limit_deg_s", g.yaw_rate_limit_deg_s, 1.0, 180.0);
}

// The law applied to what an autopilot holds level itself: X_DH is the pose of the aircraft's heading frame
// in the desired one, so the rotation is a yaw. Each limit scales its own motion and keeps the direction.
VelocitySetpoint ServoSetpoint(const Pose& X_DH, const ServoGains& gains);

}  // namespace kestrel
