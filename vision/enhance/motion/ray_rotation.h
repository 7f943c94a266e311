// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

namespace kestrel::vision {

struct RayPair {
  Eigen::Vector3d from, to;  // unit vectors
};

struct RobustRotation {
  Eigen::Quaterniond R;      // to ~ R from
  std::vector<int> inliers;  // their indices, ascending
};

// The rotation of least squares (Umeyama 1991). None: fewer than two pairs, or all along one line.
std::optional<Eigen::Quaterniond> FitRotation(std::span<const RayPair> pairs);

// The same by RANSAC from samples of two, which depend on the number of pairs alone. threshold: rad. None: fewer
// inliers than asked for.
std::optional<RobustRotation> FitRobustRotation(std::span<const RayPair> pairs, double threshold,
                                                int min_inliers);

}  // namespace kestrel::vision
