// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>

// What a camera would see if its aircraft were level. A rotorcraft must tilt to move, and the tilt moves the
// image as a motion of the target would: thesis 5.4 and 6.4 assume it small. Rotations leave the depths
// alone, so bearings of any central camera can be turned by the roll and pitch that the autopilot knows into
// a virtual camera V: the same centre, hung on the level aircraft as C hangs on the real one.
namespace kestrel::control {

// R_VC: turns vectors of C into V; the angles of thesis 4.4, rad; R_BC from the mount.
Eigen::Quaterniond LevelRotation(double roll, double pitch, const Eigen::Quaterniond& R_BC);

// "Down" in V: a constant.
Eigen::Vector3d LevelDown(const Eigen::Quaterniond& R_BC);

struct UncertainBearing {
  Eigen::Vector3d s = Eigen::Vector3d::UnitZ();          // unit vector
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // rad^2, across s
};

// The bearing in V of one in C. tilt_V: covariance of the attitude that R_VC was made of, a rotation vector
// in V, rad^2; its errors are independent of those of the bearing, but the same for all bearings of an image.
UncertainBearing Levelled(const UncertainBearing& bearing_C, const Eigen::Quaterniond& R_VC,
                          const Eigen::Matrix3d& tilt_V = Eigen::Matrix3d::Zero());

// On the image plane of V: (x/z, y/z) with its covariance; none where the bearing does not point forward.
struct UncertainPoint {
  Eigen::Vector2d s = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};
std::optional<UncertainPoint> OnImagePlane(const UncertainBearing& bearing);

// The columns of an interaction matrix, n x 6 in V, that a level aircraft has left: n x 4, by the velocity of
// the camera's centre in V, m/s, and the yaw rate about down, rad/s. Rolling and pitching do not move what V
// sees, except by the lever of a camera off the centre of rotation, which is part of that velocity.
Eigen::MatrixXd LevelInteraction(const Eigen::MatrixXd& L_V, const Eigen::Vector3d& down_V);

}  // namespace kestrel::control
