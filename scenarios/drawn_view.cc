// SPDX-License-Identifier: Apache-2.0
#include "scenarios/drawn_view.h"

#include <opencv2/imgproc.hpp>

#include "scenarios/caption.h"

namespace kestrel {

cv::Mat DrawnView(const Frame& frame, const Mission& mission, const char* mode) {
  cv::Mat drawn;
  if (frame.image.channels() == 1)
    cv::cvtColor(frame.image, drawn, cv::COLOR_GRAY2BGR);
  else
    drawn = frame.image.clone();
  mission.Draw(drawn);
  CaptionAt(drawn, {8, drawn.rows - 8}, mode);
  return drawn;
}

}  // namespace kestrel
