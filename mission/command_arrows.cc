// SPDX-License-Identifier: Apache-2.0
#include "mission/command_arrows.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "mission/caption/caption.h"
#include "vision/drawn_colours.h"

namespace kestrel::mission {
namespace {

// Its ground is drawn too: without a command there is something to be seen.
void Arrow(cv::Mat& bgr, const char* name, cv::Point2d from, cv::Point2d whole, double share) {
  const cv::Point2d to = from + std::clamp(share, -1.0, 1.0) * whole;
  cv::line(bgr, from - whole, from + whole, {0, 0, 0}, 1, cv::LINE_AA);
  cv::circle(bgr, from, 3, {0, 0, 0}, cv::FILLED, cv::LINE_AA);
  const double length = cv::norm(to - from);
  if (length >= 1) {
    const double tip = std::min(0.9, 9 / length);
    cv::arrowedLine(bgr, from, to, {255, 255, 255}, 5, cv::LINE_AA, 0, tip);
    cv::arrowedLine(bgr, from, to, vision::kSetpointColour, 3, cv::LINE_AA, 0, tip);
  }
  NameMark(bgr, from + cv::Point2d(-18, bgr.rows / 12.0 + 16), name);
}

}  // namespace

void DrawCommand(cv::Mat& bgr, const control::VelocitySetpoint& command,
                 const control::VelocitySetpoint& full) {
  const double length = bgr.rows / 12.0, y = bgr.rows - length - 24, x = bgr.cols / 2.0;
  const double apart = 2.2 * length;
  Arrow(bgr, "ahead", {x - apart, y}, {0, -length}, command.v_H.x() / full.v_H.x());
  Arrow(bgr, "yaw", {x, y}, {length, 0}, command.yaw_rate / full.yaw_rate);
  Arrow(bgr, "down", {x + apart, y}, {0, length}, command.v_H.z() / full.v_H.z());
}

}  // namespace kestrel::mission
