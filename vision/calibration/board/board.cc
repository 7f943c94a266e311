// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/board.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/overloaded.h"

namespace kestrel::vision {

Eigen::Vector2i CornerGrid(const Board& board) {
  return std::visit(Overloaded{[](const Chessboard& b) { return Eigen::Vector2i(b.cols, b.rows); },
                               [](const AprilGrid& b) { return Eigen::Vector2i(2 * b.cols, 2 * b.rows); },
                               [](const CharucoBoard& b) { return Eigen::Vector2i(b.cols - 1, b.rows - 1); },
                               [](const CircleGrid& b) { return Eigen::Vector2i(b.cols, b.rows); }},
                    board);
}

std::vector<Eigen::Vector2d> Corners(const Board& board) {
  const Eigen::Vector2i grid = CornerGrid(board);
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < grid.y(); ++row) {
    for (int col = 0; col < grid.x(); ++col) {
      corners.push_back(std::visit(
          Overloaded{
              [&](const Chessboard& b) { return Eigen::Vector2d(col * b.col_m, row * b.row_m); },
              [&](const AprilGrid& b) {
                const auto along = [&](int i) {  // i / 2 tags and gaps, and for odd ones a tag
                  return (i / 2 * (1 + b.spacing) + i % 2) * b.tag_m;
                };
                return Eigen::Vector2d(along(col), along(row));
              },
              [&](const CharucoBoard& b) { return Eigen::Vector2d(col * b.square_m, row * b.square_m); },
              [&](const CircleGrid& b) {
                const double x = b.asymmetric ? 2 * col + row % 2 : col;
                return Eigen::Vector2d(x * b.spacing_m, row * b.spacing_m);
              }},
          board));
    }
  }
  return corners;
}

bool BlackLowerLeft(const CharucoBoard& board) { return board.legacy || board.rows % 2 == 1; }

std::vector<CharucoMarker> Markers(const CharucoBoard& b) {
  std::vector<CharucoMarker> markers;
  const double gap = (b.square_m - b.marker_m) / 2;
  for (int row = b.rows - 1; row >= 0; --row) {  // squares, row 0 the lowest
    for (int col = 0; col < b.cols; ++col) {
      if (((row + col) % 2 == 0) == BlackLowerLeft(b)) continue;
      markers.push_back(
          {static_cast<int>(markers.size()), {(col - 1) * b.square_m + gap, (row - 1) * b.square_m + gap}});
    }
  }
  return markers;
}

bool IsSeenWholeOnly(const Board& board) {
  return std::holds_alternative<Chessboard>(board) || std::holds_alternative<CircleGrid>(board);
}

double DetailOf(const Board& board) {
  return std::visit(
      Overloaded{[](const Chessboard& b) { return std::min(b.col_m, b.row_m); },
                 [](const AprilGrid& b) { return b.tag_m; }, [](const CharucoBoard& b) { return b.marker_m; },
                 [](const CircleGrid& b) { return b.diameter_m; }},
      board);
}

std::string Describe(const Board& board) {
  return std::visit(
      Overloaded{[](const Chessboard& b) {
                   return fmt::format("chessboard of {} x {} corners, squares of {:g} x {:g} mm", b.cols,
                                      b.rows, 1000 * b.col_m, 1000 * b.row_m);
                 },
                 [](const AprilGrid& b) {
                   return fmt::format("AprilTag grid of {} x {} tags of {:g} mm, gaps of {:g} mm", b.cols,
                                      b.rows, 1000 * b.tag_m, 1000 * b.tag_m * b.spacing);
                 },
                 [](const CharucoBoard& b) {
                   return fmt::format(
                       "Charuco board of {} x {} squares of {:g} mm with markers of {:g} mm of {}", b.cols,
                       b.rows, 1000 * b.square_m, 1000 * b.marker_m, b.dictionary);
                 },
                 [](const CircleGrid& b) {
                   return fmt::format("{} grid of {} x {} circles of {:g} mm, rows {:g} mm apart",
                                      b.asymmetric ? "asymmetric" : "symmetric", b.cols, b.rows,
                                      1000 * b.diameter_m, 1000 * b.spacing_m);
                 }},
      board);
}

}  // namespace kestrel::vision
