// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "geometry/pose.h"

namespace kestrel::vision {

// A point of the plane z = 0 of T, m, and the unit vector in C towards it.
struct PlaneRay {
  Eigen::Vector2d p_T;
  Eigen::Vector3d ray_C;
};

// X_CT of a plane from rays to four or more of its points: the homography from the plane to the sphere of
// rays by the direct linear transform, and the nearest pose to it. Rays may point anywhere, also behind, so
// it holds for any field of view. None: too few, or the points lie in a line.
std::optional<Pose> PlanePoseFromRays(std::span<const PlaneRay> pairs);

}  // namespace kestrel::vision
