// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace kestrel::app {

// Counts the images of a video that are woven of two fields (vision/interlaced.h).
class InterlaceWatch {
 public:
  // Whether this one is.
  bool Add(const cv::Mat& image);
  // What is to be told of them all; empty: nothing. input: the video's name.
  std::string Sentence(const std::string& input) const;

 private:
  int images_ = 0, interlaced_ = 0;
};

}  // namespace kestrel::app
