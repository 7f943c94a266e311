// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "vision/calibration/board/board.h"
#include "vision/calibration/calibration.h"
#include "vision/calibration/calibration_start.h"

// Which views, and which of their corners, are of one camera.
namespace kestrel::vision {

// Beyond this many deviations a corner's error is no noise.
inline constexpr double kOutlier = 5;

// The corners of the usable views. A corner's error has a part of its own, which its fit knows, and one that
// is common to all: what the models of corner and lens leave out.
// shape: where the corners are beside the file.
std::vector<std::vector<SeenPoint>> PointsOf(const Board& board, std::span<const BoardView> views,
                                             const std::vector<std::size_t>& usable, double common_px,
                                             const BoardShape& shape = {});

// The views that agree, with those of their corners whose errors are noise.
struct Agreeing {
  Adjustment adjustment;
  std::vector<std::size_t> numbers;               // of its views, among the usable
  std::vector<std::vector<std::size_t>> corners;  // of their points, among the view's
};

// Numbers that were seen less those that are found, `free` of them of the camera.
double FreedomOf(const Agreeing& agreeing, std::size_t free);

// left_out: of the usable views, why one does not agree; empty where it does.
Agreeing SelectAgreeing(const PlacedViews& placed, std::vector<std::string>& left_out);

// The common part of the corners' errors, px: with it, errors are as large as they are expected to be.
double CommonError(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                   const Agreeing& agreeing, std::size_t free);

// Large errors count less and less as the rest gets better. The board is held.
PlacedViews AdjustRobustly(const CameraModel& start, const std::vector<int>& free,
                           const std::vector<std::vector<SeenPoint>>& points);

}  // namespace kestrel::vision
