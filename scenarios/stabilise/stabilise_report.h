// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "mission/path/path_pilot.h"
#include "vision/camera/camera_model.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::scenarios {

// An image of the stabilised video, without its pixels.
struct ShownImage {
  std::int64_t sequence = 0;  // of the frame that it was made from
  double t_s = 0;             // of its exposure
  vision::StabilisedState state = vision::StabilisedState::kFirst;
  int inliers = 0;
  double strength = 1;
  vision::ImageView view;
  bool by_opencl = false;  // points are followed on a device of OpenCL
};

struct StabiliseReport final : mission::PathReport {
  std::shared_ptr<const vision::CameraModel> camera;
  double zoom = 1;                  // px of the view in one of the image
  std::optional<ShownImage> shown;  // in this frame; none: not so many have come yet
};

}  // namespace kestrel::scenarios
