// SPDX-License-Identifier: Apache-2.0
#include "records/video/drawn_view.h"

#include <opencv2/imgproc.hpp>

#include "mission/caption.h"

namespace kestrel::records {

namespace {

cv::Mat InColour(const cv::Mat& image) {
  cv::Mat drawn;
  if (image.channels() == 1)
    cv::cvtColor(image, drawn, cv::COLOR_GRAY2BGR);
  else
    drawn = image.clone();
  return drawn;
}

cv::Mat WithMode(cv::Mat drawn, const std::string& mode) {
  cv::copyMakeBorder(drawn, drawn, 0, kModeStrip_px, 0, 0, cv::BORDER_CONSTANT);
  mission::CaptionAt(drawn, {8, drawn.rows - 7}, mode);
  return drawn;
}

}  // namespace

cv::Mat DrawnView(const vision::Frame& frame, const mission::Mission& mission, const std::string& mode) {
  cv::Mat drawn = InColour(frame.image);
  mission.Draw(drawn);
  return WithMode(drawn, mode);
}

cv::Mat DrawnView(const vision::Frame& frame, const std::string& mode) {
  return WithMode(InColour(frame.image), mode);
}

}  // namespace kestrel::records
