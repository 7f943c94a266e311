// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "vision/calibration/board/board_detector.h"

namespace kestrel::vision {

// The circles of a whole grid by OpenCV's detector, each at the middle of its darkness in the image; by index, empty:
// no grid. A symmetric grid looks the same upside down, and is taken to stand upright. grey: CV_8UC1.
std::vector<BoardCorner> FindCircleGrid(const cv::Mat& grey, const CircleGrid& board);

// The same, with what is seen moved from the middle of a disc's image to the image of its middle, which perspective and
// a lens part by some tenths of a pixel.
std::vector<BoardCorner> RefitCircleGrid(const cv::Mat& grey, const CircleGrid& board,
                                         std::span<const BoardCorner> corners, const CameraModel& camera,
                                         const Pose& X_CT);

// The diameter of each disc, m, by how dark the image is around it.
std::vector<double> SeenDiameters_m(const cv::Mat& grey, const CircleGrid& board,
                                    std::span<const BoardCorner> corners, const CameraModel& camera,
                                    const Pose& X_CT);

}  // namespace kestrel::vision
