// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/law/twist.h"
#include "geometry/pose.h"

// Position-based visual servoing, thesis 5.2.3 and 5.3: dynamic look-and-move, figure 5.4.
// Deviations: the print writes the second term of (5.9) with a minus and its first cross matrix with a
// square; for theta u of R_DC, the moving frame seen in the desired one, the sign is a plus. (5.10) has lost
// an inverse in its last block, (5.11) its stars.
namespace kestrel::control {

// The decoupled law, eq. (5.13): v = -lambda R_DC^T t_DC, w = -lambda theta u, where X_DC is the pose of the
// moving frame C in the desired frame D. Under it the position error falls along a straight line and the
// rotation about a fixed axis, both as exp(-lambda t).
Twist PbvsTwist(const Pose& X_DC, double lambda_per_s);

// The law that holds the target's place in the camera, eq. (5.11), from the poses of the target O in the
// moving camera C and in the desired one D. Under it p_CO runs to p_DO along a straight line in C, so the
// target's origin does so in the image too, and the rotation falls about a fixed axis, both as
// exp(-lambda t); the camera's own path is curved.
Twist PbvsTargetTwist(const Pose& X_CO, const Pose& X_DO, double lambda_per_s);

// d(theta u)/dt by the angular velocity in C, where theta u, rad, is the rotation vector of R_DC; eq. (5.9).
// Of use for angles below 2 pi, where it ends.
Eigen::Matrix3d RotationVectorInteraction(const Eigen::Vector3d& theta_u);

struct ServoGains {
  double lambda_per_s = 1.1;
  double lambda_vertical_per_s = 1.2;
  double lambda_yaw_per_s = 0.8;
  double speed_limit_m_s = 1.5;
  double climb_limit_m_s = 0.8;
  double yaw_rate_limit_deg_s = 40;
};

inline void Fields(FieldVisitor& v, ServoGains& g) {
  v({"lambda_per_s", "proportional gain from horizontal position error to velocity"}, g.lambda_per_s, 0.0,
    5.0);
  v({"lambda_vertical_per_s", "proportional gain from height error to vertical velocity"},
    g.lambda_vertical_per_s, 0.0, 5.0);
  v({"lambda_yaw_per_s", "proportional gain from heading error to yaw rate"}, g.lambda_yaw_per_s, 0.0, 5.0);
  v({"speed_limit_m_s", "maximum horizontal speed that is commanded"}, g.speed_limit_m_s, 0.05, 10.0);
  v({"climb_limit_m_s", "maximum vertical speed that is commanded, up or down"}, g.climb_limit_m_s, 0.05,
    5.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate that is commanded"}, g.yaw_rate_limit_deg_s, 1.0, 180.0);
}

// The law applied to what an autopilot holds level itself: X_DH is the pose of the aircraft's heading frame
// in the desired one, so the rotation is a yaw. Each limit scales its own motion and keeps the direction.
VelocitySetpoint ServoSetpoint(const Pose& X_DH, const ServoGains& gains);

}  // namespace kestrel::control
