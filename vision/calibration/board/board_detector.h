// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "geometry/pose.h"
#include "vision/calibration/board/board.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

struct BoardCorner {
  int index = 0;  // among Corners(board)
  Eigen::Vector2d pixel;
  Eigen::Matrix2d
      covariance;  // px^2, by what is left where it was fitted (vision/calibration/board/corner_fit.h)
  // Whether the square at the lower left of the board is black, as Chessboard has it. One that is white there
  // however it is turned is seen with its colours exchanged.
  bool black_lower_left = true;
  double blur_px = 0;  // standard deviation of the light's spread there, as the fit has it; 0: not known
};

// The corners of a board in an image, by index: of a chessboard only when all of it is in view, of tags those
// that are. Nothing is known of the lens, whose distortion may be strong. Each is placed by FitCorner with
// the curvature that its neighbours on the board show; one that cannot be is left out. Empty: no board. A
// chessboard that looks the same upside down is taken to stand upright. image: 8 bits, grey or blue, green,
// red.
std::vector<BoardCorner> FindBoard(const cv::Mat& image, const Board& board);

// The same corners placed anew, now that the camera and the pose X_CT of the board are known well: then the
// directions and the curvature of the edges are, too. In a wide lens that moves them by some thousandths of a
// pixel, which many corners together would notice. One that can no longer be placed is left out.
std::vector<BoardCorner> RefitBoard(const cv::Mat& image, const Board& board,
                                    std::span<const BoardCorner> corners, const CameraModel& camera,
                                    const Pose& X_CT);

}  // namespace kestrel::vision
