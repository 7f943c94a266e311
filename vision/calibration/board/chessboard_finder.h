// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace kestrel::vision {

// The inner corners of a whole chessboard, to about a pixel.
struct SeenChessboard {
  // By rows, the lowest first, each from the left, as the board has them: it may be seen turned, not mirrored.
  std::vector<Eigen::Vector2d> corners;
  // The square at the lower left. It is white only on boards on which no half turn brings a black one there.
  bool black_lower_left = true;
};

// Looks for cols x rows corners by OpenCV's two detectors, at several sizes of the image, until one finds a
// grid that holds: its squares alternate between dark and light, all are wound the same way, and its lines
// bend no more than a lens bends them. grey: CV_8UC1. None: none of them does.
std::optional<SeenChessboard> FindChessboardCorners(const cv::Mat& grey, int cols, int rows);

// Whether such corners, by rows, are those of a chessboard in the image.
bool IsChessboard(const cv::Mat& grey, const std::vector<Eigen::Vector2d>& corners, int cols, int rows);

}  // namespace kestrel::vision
