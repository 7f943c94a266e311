// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "control/law/bearing_servo.h"
#include "control/law/point_servo.h"
#include "control/law/servo_law.h"
#include "control/law/twist.h"

// Laws of six degrees of freedom for an aircraft that has four: its velocity and its yaw. Roll and pitch are
// not free, they follow from how it accelerates, and a law that solves for them and has them dropped asks
// the translation for a part of the error only. Here the law is solved for the four: in the level camera V
// (control/law/level_camera.h) roll and pitch move nothing, and the interaction matrix loses their columns.
namespace kestrel::control {

// Of the centre of V, in V, m/s; and clockwise about down, rad/s.
struct LevelTwist {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  double yaw_rate = 0;
};

// Of a step by the columns of LevelInteraction.
LevelTwist LevelTwistOf(const ServoStep& step);
// Of a law that answers the whole twist: that about other axes than down is left out, which in V is none but
// for the errors of the attitude that V is made of.
LevelTwist LevelTwistOf(const Twist& twist_V, const Eigen::Vector3d& down_V);

// PointServo and BearingServo in V. down_V: LevelDown.
ServoStep LevelPointServo(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                          InteractionChoice choice, const Eigen::Vector3d& down_V, double lambda_per_s);
ServoStep LevelBearingServo(std::span<const BearingPoint> now, std::span<const BearingPoint> wanted,
                            InteractionChoice choice, const Eigen::Vector3d& down_V, double lambda_per_s);

}  // namespace kestrel::control
