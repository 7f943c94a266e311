// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vision/landmark/plane/homography.h"

// How an image moves from one to the next as a plane does, thesis 4.2.
namespace kestrel::vision {

enum class MotionModel {
  kEuclidean,   // rotation and translation
  kSimilarity,  // and one scale
  kAffine,
  kHomography,
};

// Their names in files, "euclidean" and so on, in the order above.
const std::vector<std::string>& MotionModelNames();
// None: no such name.
std::optional<MotionModel> MotionModelNamed(const std::string& name);
const std::string& NameOf(MotionModel model);
// How many pairs fix it: two, two, three, four.
int MinPairs(MotionModel model);

// H with to ~ H from, scaled to H(2, 2) = 1, of least squares: Euclidean and similarity by Umeyama 1991, affine by
// the normal equations, the homography by FitHomography. The thesis takes three pairs for the Euclidean model and a
// general linear system, whose solution is none of that model. None: too few pairs, or a set that leaves H open.
std::optional<Eigen::Matrix3d> FitMotion(std::span<const PointPair> pairs, MotionModel model);

struct RobustMotionOptions {
  double threshold_px = 1.5;  // distance of an inlier, in the image that is moved to
  double confidence = 0.999;
  int max_trials = 400;
  int min_inliers = 12;
};

struct RobustMotion {
  Eigen::Matrix3d H;         // of least squares over all inliers, H(2, 2) = 1
  std::vector<int> inliers;  // their indices, ascending
  double rms_px = 0;         // of the inliers
};

// RANSAC (thesis, algorithm 1): samples of the smallest size, the best of which is fitted again to its inliers. The
// samples depend on nothing but the number of pairs. None: fewer inliers than asked for.
std::optional<RobustMotion> FitRobustMotion(std::span<const PointPair> pairs, MotionModel model,
                                            const RobustMotionOptions& options);

}  // namespace kestrel::vision
