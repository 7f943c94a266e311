// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "control/law/servo_law.h"

// Points on the unit sphere about a central camera of any field of view, thesis 6.4, eqs. (6.24) to (6.27).
// Deviations from (6.25), each against the derivative of (6.24): in the first row the signs of v_x, v_y and
// w_x are turned and w_x, w_y are divided by a sine that is not there; in the second all signs are turned and
// the translation has an L too many.
namespace kestrel::control {

// Of a unit vector in a frame whose z axis is the pole: colatitude from z, [0, pi], which the thesis calls
// elevation; azimuth from x to y, (-pi, pi]. In B (x ahead, y right, z down) the azimuth is the relative
// bearing, to the right positive; eq. (6.23) is R_BS of a camera that looks ahead.
struct SpherePoint {
  double colatitude = 0;
  double azimuth = 0;
};
SpherePoint SpherePointOf(
    const Eigen::Vector3d& s);  // eq. (6.24), over the whole sphere; azimuth 0 at a pole
Eigen::Vector3d BearingOf(const SpherePoint& point);

// d(colatitude, azimuth)/dt by the twist (v, w) of the frame, for a point at the distance L, m; eq. (6.25).
// None at the poles, where the azimuth is not defined, and near them it is steep: there use bearings.
std::optional<Eigen::Matrix<double, 2, 6>> SpherePointInteraction(const SpherePoint& point, double L);

// ds/dt of a unit vector s by the twist of the frame it is given in: -(I - s s^T)/L v + [s]x w, of rank 2.
// No pole: it is as good anywhere on the sphere.
Eigen::Matrix<double, 3, 6> BearingInteraction(const Eigen::Vector3d& s, double L);

struct BearingPoint {
  Eigen::Vector3d s = Eigen::Vector3d::UnitZ();  // unit vector
  double L = 0;                                  // distance, m
};
// Of n bearings, one below the other, 3n x 6.
Eigen::MatrixXd BearingInteraction(std::span<const BearingPoint> points);

// As PointServo, for points anywhere about the camera, behind it too: the error is the chord s - s*.
ServoStep BearingServo(std::span<const BearingPoint> now, std::span<const BearingPoint> wanted,
                       InteractionChoice choice, double lambda_per_s, const Inversion& inversion = {});

}  // namespace kestrel::control
