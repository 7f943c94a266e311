// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// Planar homographies, thesis 3.2.3 (equations 3.13 to 3.15, algorithm 1).
namespace kestrel::vision {

struct PointPair {
  Eigen::Vector2d from, to;
};

// H with to ~ H from, scaled to unit Frobenius norm. Exactly four pairs: the inhomogeneous solution, eq.
// (3.15), through the pair set's own scale, so that h33 = 0 is no special case. More: the homogeneous
// solution of eq. (3.14) by SVD, after Hartley's normalisation, which the thesis leaves out and without which
// the algebraic error means little. None: fewer than four pairs or a degenerate set.
std::optional<Eigen::Matrix3d> FitHomography(std::span<const PointPair> pairs);

// H x, dehomogenised.
Eigen::Vector2d Transfer(const Eigen::Matrix3d& H, const Eigen::Vector2d& x);

struct RansacOptions {
  double threshold = 2;      // t: symmetric transfer distance up to which a pair agrees, px
  double confidence = 0.99;  // p: probability of at least one sample free of outliers
  int max_trials = 1000;
  int min_inliers = 8;  // "Consensus": fewer is no answer
};

struct RobustHomography {
  Eigen::Matrix3d H;         // fitted to all inliers
  std::vector<int> inliers;  // their indices, ascending
  double rms = 0;            // root mean square of the inliers' forward distance, px
};

// Algorithm 1 of the thesis. Deviations: the final fit is repeated once on the inliers of the fit itself, and
// the outlier share starts at 1 (no guess needed). The sample sequence depends on the seed alone.
std::optional<RobustHomography> RansacHomography(std::span<const PointPair> pairs,
                                                 const RansacOptions& options, std::uint32_t seed = 1);

}  // namespace kestrel::vision
