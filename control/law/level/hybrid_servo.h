// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "control/law/point_servo.h"
#include "control/law/twist.h"

// Visual servoing of 2 1/2 dimensions: Malis, Chaumette and Boudet, "2-1/2-D visual servoing", IEEE Trans.
// Robotics and Automation 15(2), 1999. The features are those of one point in the image, the logarithm of
// its depth, and the rotation:
//
//   s = (x, y, ln Z, theta u)
//
// Depth and rotation come from a homography between the image and that of the goal, and of the depth the
// ratio Z/Z* alone is in the error, so that no size of the target need be known but Z*, by which the gain of
// the translation is scaled.
namespace kestrel::control {

// d(x, y, ln Z)/dt by the twist (v, w) of C. Z > 0.
Eigen::Matrix<double, 3, 6> DepthPointInteraction(const Eigen::Vector2d& s, double Z);

// theta_u: rotation vector of R_DC, the present camera in the desired one. Both depths positive. The matrix is
// triangular: w = -lambda theta u, and v makes up for what that turn does to the point.
Twist HybridTwist(const ImagePoint& now, const ImagePoint& wanted, const Eigen::Vector3d& theta_u,
                  double lambda_per_s);

}  // namespace kestrel::control
