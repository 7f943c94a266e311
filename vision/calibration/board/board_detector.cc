// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/board_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/calibration/board/charuco_finder.h"
#include "vision/calibration/board/chessboard_finder.h"
#include "vision/calibration/board/circle_finder.h"
#include "vision/calibration/board/corner_map.h"
#include "vision/calibration/board/tag_grid_finder.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kLeastRadius_px = 2.5;

// By the corners on the line; where these are too few, as of a tag that has no neighbour there, by the tag's
// own sides.
std::optional<CornerMap::Line> LineAt(const cv::Mat& grey, const Board& board, const CornerMap& map, int col,
                                      int row, int axis) {
  const auto line = map.LineAt(col, row, axis);
  const AprilGrid* grid = std::get_if<AprilGrid>(&board);
  if (!line || line->bend_known || !grid) return line;
  std::array<Vector2d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto [c, r] = TagCorner(col / 2, row / 2, k);
    if (!map.At(c, r)) return line;
    corners[k] = *map.At(c, r);
  }
  const auto patch = TagPatch::Of(grey, corners);
  return patch ? LineIn(*patch, grid->tag_m, col % 2, row % 2, axis) : line;
}

// Fits a corner; once more within a smaller radius where what stands around it spreads by the blur.
std::optional<FittedCorner> FitFree(const cv::Mat& grey, CornerGuess guess) {
  const auto fit = FitCorner(grey, guess);
  if (!fit) return std::nullopt;
  const double free_px = std::max(guess.radius_px + 1 - 2 * fit->blur_px, kLeastRadius_px);
  if (free_px >= guess.radius_px) return fit;
  guess.pixel = fit->pixel;
  guess.radius_px = free_px;
  return FitCorner(grey, guess);
}

// Fits every corner of the map. Thrice, since the curvature of the edges is known only once their corners
// are; a corner where it is never known is left out, as is one that cannot be fitted.
std::vector<BoardCorner> FitAll(const cv::Mat& grey, const Board& board, CornerMap map,
                                bool black_lower_left) {
  std::vector<BoardCorner> corners;
  for (int pass = 0; pass < 3; ++pass) {
    corners.clear();
    CornerMap fitted = map;
    for (int row = 0; row < map.rows(); ++row) {
      for (int col = 0; col < map.cols(); ++col) {
        fitted.At(col, row).reset();
        const auto x = LineAt(grey, board, map, col, row, 0), y = LineAt(grey, board, map, col, row, 1);
        if (!x || !y) continue;
        auto guess = GuessOf(board, col, row, *map.At(col, row), *x, *y, kMinClear_px, black_lower_left);
        if (!guess) continue;
        if (pass == 0) guess->bend_x = guess->bend_y = 0;
        const auto fit = FitFree(grey, *guess);
        if (!fit) continue;
        fitted.At(col, row) = fit->pixel;
        if (x->bend_known && y->bend_known)
          corners.push_back({static_cast<int>(map.Index(col, row)), fit->pixel, fit->covariance,
                             black_lower_left, fit->blur_px});
      }
    }
    map = fitted;
  }
  return corners;
}

// A whole chessboard. In the order of Corners.
std::optional<CornerMap> FindChessboard(const cv::Mat& grey, const Board& board, const Chessboard& chess,
                                        bool& black_lower_left) {
  const auto seen = FindChessboardCorners(grey, chess.cols, chess.rows);
  if (!seen) return std::nullopt;
  black_lower_left = seen->black_lower_left;
  CornerMap map(board);
  for (int row = 0; row < chess.rows; ++row) {
    for (int col = 0; col < chess.cols; ++col) map.At(col, row) = seen->corners[map.Index(col, row)];
  }
  return map;
}

cv::Mat Grey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace

std::vector<BoardCorner> FindBoard(const cv::Mat& image, const Board& board) {
  const cv::Mat grey = Grey(image);
  if (const CircleGrid* circles = std::get_if<CircleGrid>(&board)) return FindCircleGrid(grey, *circles);
  bool black_lower_left = true;
  std::optional<CornerMap> map;
  if (const Chessboard* chess = std::get_if<Chessboard>(&board))
    map = FindChessboard(grey, board, *chess, black_lower_left);
  else if (std::holds_alternative<CharucoBoard>(board))
    map = FindCharuco(grey, board);
  else
    map = FindTagGrid(grey, board);
  if (!map) return {};
  return FitAll(grey, board, *map, black_lower_left);
}

std::vector<BoardCorner> RefitBoard(const cv::Mat& image, const Board& board,
                                    std::span<const BoardCorner> corners, const CameraModel& camera,
                                    const Pose& X_CT) {
  const cv::Mat grey = Grey(image);
  if (const CircleGrid* circles = std::get_if<CircleGrid>(&board))
    return RefitCircleGrid(grey, *circles, corners, camera, X_CT);
  const std::vector<Vector2d> places = Corners(board);
  const int cols = CornerGrid(board).x();
  std::vector<BoardCorner> refitted;
  for (const BoardCorner& corner : corners) {
    const int col = corner.index % cols, row = corner.index / cols;
    const Vector2d& place = places[static_cast<std::size_t>(corner.index)];
    const auto at = [&](const Vector2d& p) {
      return Project(camera, X_CT * Eigen::Vector3d(p.x(), p.y(), 0));
    };
    const auto line = [&](int axis) -> std::optional<CornerMap::Line> {
      const double step_m = 0.1 * SurroundingsOf(board, col, row).clear_m[axis];
      const auto before = at(place - step_m * Vector2d::Unit(axis)), here = at(place);
      const auto after = at(place + step_m * Vector2d::Unit(axis));
      if (!before || !here || !after) return std::nullopt;
      return CornerMap::Line{(*after - *before) / (2 * step_m),
                             (*after - 2 * *here + *before) / (step_m * step_m), true};
    };
    const auto x = line(0), y = line(1);
    if (!x || !y) continue;
    const auto guess = GuessOf(board, col, row, corner.pixel, *x, *y, kMinClear_px, corner.black_lower_left);
    const auto fit = guess ? FitFree(grey, *guess) : std::nullopt;
    if (fit) {
      refitted.push_back({corner.index, fit->pixel, fit->covariance, corner.black_lower_left, fit->blur_px});
    }
  }
  return refitted;
}

}  // namespace kestrel::vision
