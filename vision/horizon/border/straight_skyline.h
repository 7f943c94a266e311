// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/horizon/border/border_look.h"
#include "vision/horizon/border/border_search.h"
#include "vision/horizon/border/plane_view.h"
#include "vision/horizon/border/skyline_fix.h"

namespace kestrel::vision {

// A line that may be the horizon, after a close look at it, and the "down" that it would be the horizon of.
struct LookedAtLine {
  BorderLook look;
  BorderSides sides;
  double belief = 0;  // log of the odds that it is
  Eigen::Vector3d down_C;
};

// Attitude from one image of a lens that looks one way, in whose view the horizon is a straight line, without any
// guess: photographs, and flights through ordinary lenses. Lines are searched for over the whole image, looked at
// closely, and judged by what lies above and below them.
class StraightSkyline {
 public:
  // down_C: of a level aircraft, which tilts by no more than max_tilt (rad). forbidden: CV_8UC1 of the camera's
  // size, not 0 where the aircraft itself is seen; or empty.
  StraightSkyline(const CameraModel& camera, const cv::Mat& forbidden, const Eigen::Vector3d& down_C,
                  double max_tilt);

  // Whether all that a camera sees lies within some 60 degrees of its optical axis.
  static bool Suits(const CameraModel& camera);

  // image: CV_8UC3 of the camera's size.
  SkylineResult Measure(const cv::Mat& image) const;
  // The lines that it chooses from, the likeliest first.
  std::vector<LookedAtLine> Lines(const cv::Mat& image) const;

 private:
  PlaneView plane_;
  Eigen::Vector3d down_C_;
  double max_tilt_;
};

}  // namespace kestrel::vision
