// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace kestrel::mission {

// A line of text in the upper left corner of a video's frame, legible on any ground. row: from 0.
void Caption(cv::Mat& bgr, int row, const std::string& text);

// The same anywhere: at the left end of its base line.
void CaptionAt(cv::Mat& bgr, const cv::Point& at, const std::string& text);

}  // namespace kestrel::mission
