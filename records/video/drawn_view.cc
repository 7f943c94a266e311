// SPDX-License-Identifier: Apache-2.0
#include "records/video/drawn_view.h"

#include <opencv2/imgproc.hpp>

#include "mission/caption.h"

namespace kestrel::records {

cv::Mat DrawnView(const vision::Frame& frame, const mission::Mission& mission, const std::string& mode) {
  cv::Mat drawn;
  if (frame.image.channels() == 1)
    cv::cvtColor(frame.image, drawn, cv::COLOR_GRAY2BGR);
  else
    drawn = frame.image.clone();
  mission.Draw(drawn);
  cv::copyMakeBorder(drawn, drawn, 0, kModeStrip_px, 0, 0, cv::BORDER_CONSTANT);
  mission::CaptionAt(drawn, {8, drawn.rows - 7}, mode);
  return drawn;
}

}  // namespace kestrel::records
