// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "control/law/servo_law.h"

// Following a sphere, such as a balloon, by the centre and the diameter of its image; thesis 5.4, eqs. (5.16)
// to (5.25), which agree with their definitions. What they define is the image of a disc that is held
// parallel to the image plane: the outline of a sphere of diameter D at the distance d is larger, on the axis
// by 1 / sqrt(1 - (D / 2d)^2), and off it an ellipse.
namespace kestrel::control {

struct SphereImage {
  Eigen::Vector2d s = Eigen::Vector2d::Zero();  // centre, (X/Z, Y/Z) in C
  double diameter = 0;                          // D / Z, without unit: pixels over the focal length
  Eigen::Vector3d Vector() const { return {s.x(), s.y(), diameter}; }
};

// The image of a sphere of diameter D, m, whose centre is p_CT, eq. (5.16), Z > 0; and its depth Z = D /
// image.
SphereImage SphereImageOf(const Eigen::Vector3d& p_CT, double D);
double SphereDepth(const SphereImage& image, double D);

// d(x, y, diameter)/dt by the twist (v, w) of C, eq. (5.18). Z > 0.
Eigen::Matrix<double, 3, 6> SphereInteraction(const SphereImage& image, double Z);

// The same by (v_y, v_z, w_y) alone, eq. (5.19): what is left to a camera that looks ahead from an aircraft
// which holds its roll and pitch; and its inverse, eq. (5.20), which exists wherever diameter and Z do.
Eigen::Matrix3d FollowInteraction(const SphereImage& image, double Z);
Eigen::Matrix3d FollowInverse(const SphereImage& image, double Z);

// The loops by themselves, eqs. (5.24) and (5.25): y by v_y, diameter by v_z, x by w_y, the pairing that the
// relative gain array gives (control/law/relative_gain.h).
Eigen::Matrix3d DecoupledInteraction(const SphereImage& image, double Z);
Eigen::Matrix3d DecoupledInverse(const SphereImage& image, double Z);

// How the image moves by itself, 1/s: d(x, y, diameter)/dt by the velocity of the sphere relative to C, m/s,
// in the directions that the law does not command as well as in those that it does.
Eigen::Vector3d SphereDrift(const SphereImage& image, double Z, const Eigen::Vector3d& v_C);

// Eq. (5.21): velocity (v_y, v_z, w_y) of C, m/s and rad/s, that brings the image to the one wanted. With the
// whole inverse the three errors fall as exp(-lambda t), each with its own lambda and all on a straight line
// if it is the same; decoupled, each as its own loop, disturbed by the others away from the axis. drift: what
// of the image's motion is known beforehand and taken back; the thesis has none, and lags behind what moves.
enum class FollowCoupling { kCoupled, kDecoupled };
struct FollowStep {
  ServoState state = ServoState::kNotFinite;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // zero unless the state is kRegular
};
FollowStep FollowVelocity(const SphereImage& now, const SphereImage& wanted, double Z,
                          FollowCoupling coupling, const Eigen::Vector3d& lambda_per_s,
                          const Eigen::Vector3d& drift = Eigen::Vector3d::Zero());

}  // namespace kestrel::control
