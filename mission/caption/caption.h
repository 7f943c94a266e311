// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace kestrel::mission {

// A few words or figures about a frame, which a video has below its image.
struct Caption {
  std::string text;
  bool alarm = false;  // something is as it should not be
};

// The name of a mark, beside it in the image: at the left end of its base line, legible on any ground.
void NameMark(cv::Mat& bgr, const cv::Point& at, const std::string& name);

}  // namespace kestrel::mission
