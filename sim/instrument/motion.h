// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "geometry/pose.h"
#include "geometry/truth.h"

namespace kestrel::sim {

// How the aircraft moves at an instant within a step of the physics.
struct Motion {
  Pose X_NB;
  Eigen::Vector3d v_N, w_B;                  // m/s, rad/s
  Eigen::Vector3d acceleration_N, w_rate_B;  // m/s^2, rad/s^2
};

// Between the states before and after the step, of which share (0 to 1) has passed: position, velocity and
// angular rate on the straight line between theirs, the attitude on the shortest turn between theirs (slerp),
// as images have it too; accelerations are the differences over the step, the same for all of it, as the
// physics integrate them (semi-implicit Euler).
Motion Between(const Truth& before, const Truth& after, double share);

// Of a point that is fixed to the aircraft, in N.
Eigen::Vector3d PointVelocity(const Motion& motion, const Eigen::Vector3d& p_B);
Eigen::Vector3d PointAcceleration(const Motion& motion, const Eigen::Vector3d& p_B);

}  // namespace kestrel::sim
