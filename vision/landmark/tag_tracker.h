// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"
#include "vision/tag/tag.h"
#include "vision/tag/tag_detector.h"

namespace kestrel::vision {

struct TagsSeen {
  PlanePose pose;
  std::vector<PointPair> corners;  // from T, m, to the image: four of each tag that agrees
  int tags = 0;
};

// A pad of tags in one image after another: each is searched anew, and the pose is that of all corners together.
// Of two pads alike the one is taken that is nearest to where the pad is expected, or was.
class TagTracker {
 public:
  TagTracker(std::vector<Tag> tags, const Pinhole& camera);

  // grey: CV_8UC1. None: no tag of the pad is wholly in the image, or none that can be read.
  std::optional<TagsSeen> Track(const cv::Mat& grey, const std::optional<Pose>& X_CT_expected);

 private:
  std::vector<Tag> tags_;
  Pinhole camera_;
  TagDetector detector_;
  std::optional<Pose> X_CT_last_;  // none: not seen, or long ago
  int lost_frames_ = 0;
};

}  // namespace kestrel::vision
