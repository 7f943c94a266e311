// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "vision/target/balloon_tracker.h"

namespace kestrel::vision {

// What all trackers of a target have in common, to compare them on the same images (CV_8UC3). Boxes: the
// first pixel spans 0 to 1. Nothing throws; none: lost.
struct BoxTracker {
  std::string name;
  // The first image with the target's box in it, for those that learn it there; anew each time.
  std::function<bool(const cv::Mat& bgr, const cv::Rect2d& box)> start;
  std::function<std::optional<cv::Rect2d>(const cv::Mat& bgr)> track;
};

BoxTracker CamShiftBoxes(const ColourModel& model, const ColourTrackerOptions& options = {});
BoxTracker BalloonBoxes(const ColourModel& model, const CameraModel& camera,
                        const BalloonTrackerOptions& options = {});
// OpenCV's correlation filters: KCF (Henriques et al. 2015) and CSRT (Lukezic et al. 2017).
BoxTracker KcfBoxes();
BoxTracker CsrtBoxes();

// Area of what two boxes share over the area of both together.
double Overlap(const cv::Rect2d& a, const cv::Rect2d& b);

}  // namespace kestrel::vision
