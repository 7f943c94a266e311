// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace kestrel::bench {

// What trackers of a known flat picture have in common, to compare them on the same images (CV_8UC1).
// Homographies are from T, m (bench/planar/planar_sequence.h), to the image. Nothing throws; none: lost.
struct PlanarTracker {
  std::string name;
  // The first image with the truth of it; anew each time.
  std::function<void(const cv::Mat& grey, const Eigen::Matrix3d& H_w)> start;
  std::function<std::optional<Eigen::Matrix3d>(const cv::Mat& grey)> track;  // the next images
};

// Of Kestrel: the helipad's tracker (vision/landmark/pad_tracker.h), registered to the picture, or chaining
// homographies alone as the thesis does.
PlanarTracker PadPlanarTracker(const cv::Mat& picture, bool registration);
// OpenCV's ECC (G. Evangelidis and E. Psarakis, "Parametric image alignment using enhanced correlation
// coefficient maximization", PAMI 30(10), 2008) from where the picture was in the image before, from coarse
// to fine.
PlanarTracker EccPlanarTracker(const cv::Mat& picture);

// All that are compared, ours first: a new one is a line here.
std::vector<PlanarTracker> PlanarTrackers(const cv::Mat& picture);

}  // namespace kestrel::bench
