// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "vision/calibration/board/corner_map.h"

namespace kestrel::vision {

// The corners of a Charuco board in an image, those beside a marker that is seen, to about a pixel. A corner is looked
// for where its marker has it, and taken if it looks like one. board: a CharucoBoard. grey: CV_8UC1. None: no corner.
std::optional<CornerMap> FindCharuco(const cv::Mat& grey, const Board& board);

}  // namespace kestrel::vision
