// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "control/law/level/level_servo.h"
#include "control/law/point_servo.h"

// Servoing on the image of a virtual camera that stays level under the aircraft: Hamel and Mahony, "Visual
// servoing of an under-actuated dynamic rigid-body system: an image-based approach", IEEE Trans. Robotics and
// Automation 18(2), 2002, in the form that Tahri and Chaumette's normalised moments give it ("Point-based and
// region-based image moments for visual servoing of planar objects", IEEE Trans. Robotics 21(6), 2005). Of
// points in a level plane the centroid, scaled by their spread, moves as the target does:
//
//   q = sqrt(a*/a) (x_g, y_g, 1),   dq/dt = -v / Z* - w_z z x q
//
// with a the sum of the squared distances from the centroid. No depth but Z* is in it, and no singularity.
// Deviation: the angle is that of the turn which fits all points, so it knows half a turn from none.
namespace kestrel::control {

struct LevelImage {
  Eigen::Vector3d q = Eigen::Vector3d::UnitZ();
  double angle = 0;  // by which the points wanted are turned to be those that there are, from x to y, rad
};
// As seen by a level camera that looks straight down; wanted: the same points, with their spread as a*.
LevelImage LevelImageOf(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted);

// dq/dt by (v, w_z) of that camera, 3 x 4.
Eigen::Matrix<double, 3, 4> LevelImageInteraction(const Eigen::Vector3d& q, double Z_wanted);

// The depth wanted is the mean of those of the points wanted; the present depths are not used.
LevelTwist LevelImageTwist(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                           double lambda_per_s);

}  // namespace kestrel::control
