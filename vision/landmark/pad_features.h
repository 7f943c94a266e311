// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/features/features.h"
#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// Finds a pad where PadDetector has no rectangle to go by, as only a part of it is in view or in the sun: features
// (thesis 3.2.2) of the image matched with those of the reference at three of its scales, and a RANSAC homography.
// Some tens of milliseconds an image. Those of the last reference are kept, as most flights of a process are over the
// same pad as the one before.
class PadFeatures {
 public:
  PadFeatures(const PadReference& reference, const Pinhole& camera,
              FeatureDetector detector = FeatureDetector::kSift);

  // Finds those of the reference now, which takes some 60 MB for as long as it lasts, and not in a flight.
  static void Prepare(const PadReference& reference, FeatureDetector detector) {
    ScalesOf(reference, detector);
  }

  // H_w, the homography from T, m, to the image (CV_8UC1), good to about a pixel. None: too few matches
  // agree.
  std::optional<Eigen::Matrix3d> Find(const cv::Mat& grey, std::uint32_t seed) const;
  // The same for a pad that is small in the image, in every pixel of one part of it: of the parts that have the
  // most contrast, the one of this rank. None also where Find leaves no pixel out.
  std::optional<Eigen::Matrix3d> FindSmall(const cv::Mat& grey, int rank, std::uint32_t seed) const;

 private:
  struct Scale {
    Features features;
    std::vector<Eigen::Vector2d> places;  // of the features, in T, m
  };
  static std::shared_ptr<const std::vector<Scale>> ScalesOf(const PadReference& reference,
                                                            FeatureDetector detector);
  bool Halves(const cv::Mat& grey) const;
  // The image's features are in pixels of it.
  std::optional<Eigen::Matrix3d> Match(const Features& found, std::uint32_t seed) const;

  Pinhole camera_;
  FeatureDetector detector_;
  std::shared_ptr<const std::vector<Scale>> scales_;
};

}  // namespace kestrel::vision
