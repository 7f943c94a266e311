// SPDX-License-Identifier: Apache-2.0
#include "records/video/drawn_view.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "mission/caption/strip.h"

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

constexpr int kRows = 3, kRowsWithoutMission = 1;

std::string Clock(double t_s) { return fmt::format("{:7.2f} s", t_s); }

}  // namespace

cv::Mat DrawnView(const vision::Frame& frame, double t_s, const mission::Mission& mission,
                  const std::string& mode) {
  cv::Mat drawn = InColour(frame.image);
  mission.Draw(drawn);
  return mission::WithStrip(drawn, {Clock(t_s), mode, mission.Captions()}, kRows);
}

cv::Mat DrawnView(const vision::Frame& frame, double t_s, const std::string& mode) {
  return mission::WithStrip(InColour(frame.image), {Clock(t_s), mode, {}}, kRowsWithoutMission);
}

}  // namespace kestrel::records
