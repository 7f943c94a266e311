// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "control/law/level/level_servo.h"
#include "control/law/point_servo.h"

// Partitioned image-based visual servoing: Corke and Hutchinson, "A new partitioned approach to image-based
// visual servo control", IEEE Trans. Robotics and Automation 17(4), 2001. Motion along and about the optical
// axis has features of its own, the area of the polygon of points and the angle of a line between two of
// them, and the points have what is left. So a turn about the axis is a turn, and no retreat.
//
// Deviations: roll and pitch rates are none of the aircraft's freedoms, so that v_x and v_y alone are solved
// for; the gains are scaled such that near the goal all errors fall as exp(-lambda t); the potential that
// keeps points in the image is left out.
namespace kestrel::control {

// Of a polygon: root of its area (a ratio to the focal length), and direction of the line from its first
// point to that half way round, rad, from x to y.
struct PolygonImage {
  double size = 0;
  double angle = 0;
};
PolygonImage PolygonImageOf(std::span<const ImagePoint> points);

// In a level camera that looks straight down: yaw is the turn about its axis. Three points or more, in order
// around the polygon, all depths positive; the depths are the current ones.
LevelTwist PartitionedTwist(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                            double lambda_per_s);

}  // namespace kestrel::control
