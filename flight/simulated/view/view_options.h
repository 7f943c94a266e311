// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "sim/view/view_parameters.h"

namespace kestrel::flight {

// A flight seen from outside.
struct ViewOptions {
  sim::ViewParameters parameters;
  bool with_camera = false;  // what the camera on board sees, in a corner of the picture
  bool video = true;         // view.mp4, where there are records
  // Of each picture as soon as it is drawn, on the thread that draws.
  std::function<void(double t_s, const cv::Mat& bgr)> on_frame = {};
};

}  // namespace kestrel::flight
