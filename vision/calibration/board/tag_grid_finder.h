// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "vision/calibration/board/corner_map.h"

namespace kestrel::vision {

// The tags of an AprilGrid in an image: those that are found by themselves, then, from each to its neighbours, those
// that are where the grid has them. board: an AprilGrid. grey: CV_8UC1.
CornerMap FindTagGrid(const cv::Mat& grey, const Board& board);

}  // namespace kestrel::vision
