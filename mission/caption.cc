// SPDX-License-Identifier: Apache-2.0
#include "mission/caption.h"

#include <opencv2/imgproc.hpp>

namespace kestrel::mission {

void Caption(cv::Mat& bgr, int row, const std::string& text) { CaptionAt(bgr, {8, 20 + 18 * row}, text); }

void CaptionAt(cv::Mat& bgr, const cv::Point& at, const std::string& text) {
  cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, {255, 255, 255}, 1, cv::LINE_AA);
}

}  // namespace kestrel::mission
