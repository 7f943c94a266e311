// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/landmark/alignment/alignment.h"
#include "vision/landmark/features/features.h"
#include "vision/landmark/pad_tracking.h"

namespace kestrel::bench {

// What trackers of a known flat picture have in common, to compare them on the same images (CV_8UC1).
// Homographies are from T, m (bench/planar/planar_sequence.h), to the image. Nothing throws; none: lost.
struct PlanarTracker {
  std::string name;
  bool ours = true;  // and not a peer's
  // The first image with the truth of it; anew each time.
  std::function<void(const cv::Mat& grey, const Eigen::Matrix3d& H_w)> start;
  std::function<std::optional<Eigen::Matrix3d>(const cv::Mat& grey)> track;  // the next images
};

// Of Kestrel: the helipad's tracker (vision/landmark/pad_tracker.h) by one of its methods; without registration
// it chains homographies alone, as the thesis does.
PlanarTracker PadPlanarTracker(const cv::Mat& picture, const vision::PadTrackerOptions& options,
                               const std::string& name);
// The picture's alignment by itself (vision/landmark/alignment), from where it was in the image before.
PlanarTracker AlignerPlanarTracker(const cv::Mat& picture, vision::AlignmentMethod method,
                                   const std::string& name);
// The picture found anew in each image by features of one kind (vision/landmark/pad_features.h).
PlanarTracker FeaturesPlanarTracker(const cv::Mat& picture, vision::FeatureDetector detector);
// OpenCV's ECC (G. Evangelidis and E. Psarakis, "Parametric image alignment using enhanced correlation
// coefficient maximization", PAMI 30(10), 2008) from where the picture was in the image before, from coarse
// to fine.
PlanarTracker EccPlanarTracker(const cv::Mat& picture);

// All that are compared, the pad's tracker as it flies first: a new one is a line here.
std::vector<PlanarTracker> PlanarTrackers(const cv::Mat& picture);

}  // namespace kestrel::bench
