// SPDX-License-Identifier: Apache-2.0
#include "mission/caption/caption.h"

#include <opencv2/imgproc.hpp>

namespace kestrel::mission {

void NameMark(cv::Mat& bgr, const cv::Point& at, const std::string& name) {
  cv::putText(bgr, name, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(bgr, name, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, {255, 255, 255}, 1, cv::LINE_AA);
}

}  // namespace kestrel::mission
