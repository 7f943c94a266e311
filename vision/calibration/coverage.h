// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "vision/calibration/calibration.h"

namespace kestrel::vision {

// The image in cells: which of them lie within the lens, and how many used corners each has. What is dark in
// all the images, grey ones of the views, is beyond the rim of the lens or mirror.
struct Coverage {
  int cols = 16, rows = 12;
  std::vector<bool> in_lens;  // by rows
  std::vector<int> corners;
  double share = 0;  // of the cells within the lens that have a corner
};
Coverage CoverageOf(const Calibration& calibration, std::span<const cv::Mat> images);

}  // namespace kestrel::vision
