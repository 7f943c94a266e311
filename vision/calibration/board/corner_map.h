// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "vision/calibration/board/board.h"
#include "vision/calibration/board/corner_fit.h"
#include "vision/calibration/board/tag_finder.h"

// How a board's corners are expected, and found, in an image: what its detectors share.
namespace kestrel::vision {

// Around a corner, free of anything else: to place it well, and to find it at all.
inline constexpr double kMinClear_px = 3.2, kMinToFind_px = 2;

// Where the corners of a board have been seen so far: by row and column of its grid.
class CornerMap {
 public:
  explicit CornerMap(const Board& board)
      : grid_(CornerGrid(board)), places_(Corners(board)), seen_(places_.size()) {}

  int cols() const { return grid_.x(); }
  int rows() const { return grid_.y(); }
  const Eigen::Vector2d& Place(int col, int row) const { return places_[Index(col, row)]; }
  std::optional<Eigen::Vector2d>& At(int col, int row) { return seen_[Index(col, row)]; }
  const std::optional<Eigen::Vector2d>& At(int col, int row) const { return seen_[Index(col, row)]; }
  std::size_t Index(int col, int row) const { return static_cast<std::size_t>(row * grid_.x() + col); }

  // How the image of the line through a corner along axis 0 (x) or 1 (y) of the board runs there: its
  // derivatives by the board's coordinate, px/m and px/m^2, of the polynomial through it and the nearest
  // others on it; with a single one, the first alone.
  struct Line {
    Eigen::Vector2d tangent, second = Eigen::Vector2d::Zero();
    bool bend_known = false;
  };
  std::optional<Line> LineAt(int col, int row, int axis) const;

 private:
  Eigen::Vector2i grid_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<std::optional<Eigen::Vector2d>> seen_;
};

// Of the quarters around a corner: whether that between +x and +y is black. And how far along x and y of the
// board nothing else is seen, m.
struct Surroundings {
  bool black_between = false;
  Eigen::Vector2d clear_m;
};
Surroundings SurroundingsOf(const Board& board, int col, int row);

// What is to be expected at a corner whose lines are known. None: too small to be placed.
std::optional<CornerGuess> GuessOf(const Board& board, int col, int row, const Eigen::Vector2d& pixel,
                                   const CornerMap::Line& x, const CornerMap::Line& y, double least_clear_px,
                                   bool black_lower_left = true);

// How the line along an axis runs at a place of a tag's patch, by differences of it. x, y: in sides of the tag.
CornerMap::Line LineIn(const TagPatch& patch, double side_m, double x, double y, int axis);

// Corner k of a tag in the grid of corners of an AprilGrid.
std::pair<int, int> TagCorner(int tag_col, int tag_row, std::size_t k);

// The corner near a guess. None: there is none.
std::optional<Eigen::Vector2d> FindNear(const cv::Mat& grey, CornerGuess guess, double within_px);

}  // namespace kestrel::vision
