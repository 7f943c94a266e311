// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/tag/tag.h"

namespace kestrel::vision {

struct DetectedTag {
  std::size_t index = 0;                   // in the list of tags that are looked for
  std::array<Eigen::Vector2d, 4> corners;  // px, in the order of CornersOf
  double margin = 0;                       // of its code's bits over what parts black from white, grey levels
};

// Finds tags by libapriltag's detector, those of the list alone: any other code of their families is none of
// theirs. A dictionary of ArUco is read as one more family.
class TagDetector {
 public:
  explicit TagDetector(const std::vector<Tag>& tags);
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  // grey: CV_8UC1. One tag may be there several times.
  std::vector<DetectedTag> Detect(const cv::Mat& grey) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace kestrel::vision
