// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "geometry/pose.h"
#include "vision/camera.h"

namespace kestrel::python {

// A frame with what was asked for beside its image; empty: was not.
struct ShownFrame {
  vision::Frame frame;
  cv::Mat depth, segmentation, flow;
  Pose X_NC;  // the truth at its exposure
};

}  // namespace kestrel::python
