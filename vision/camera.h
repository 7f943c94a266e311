// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

namespace kestrel::vision {

struct Frame {
  cv::Mat image;              // CV_8UC1, or CV_8UC3 in the order blue, green, red; row 0 is the top
  double t_s = 0;             // middle of the exposure, on the autopilot's clock
  std::int64_t sequence = 0;  // counts exposures from 0; a gap is a lost frame
};

// Where frames come from: the simulator, a real camera, a recording.
class Camera {
 public:
  virtual ~Camera() = default;
  // The next frame, waiting for it. None: the stream has ended.
  virtual std::optional<Frame> Next() = 0;
};

}  // namespace kestrel::vision
