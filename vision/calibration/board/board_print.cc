// SPDX-License-Identifier: Apache-2.0
#ifndef KESTREL_WITHOUT_APRILTAG
#include <apriltag/tag36h11.h>
#endif

#include <algorithm>
#include <cmath>

#include "base/overloaded.h"
#include "vision/calibration/board/board.h"
#include "vision/calibration/board/tag_36h11.h"
#include "vision/tag/tag_family.h"

namespace kestrel::vision {
namespace {

// What boards are made of: cells between which every edge falls, and the sheet counted in them. The
// lowest corner has `before` cells to its left, and as many below it.
struct CellGrid {
  Eigen::Vector2d cell_m;
  Eigen::Vector2d cells;  // along x and y of the sheet
  double before = 0;
};

CellGrid Cells(const Board& board) {
  return std::visit(
      Overloaded{
          [](const Chessboard& b) {
            return CellGrid{{b.col_m, b.row_m}, {b.cols + 3.0, b.rows + 3.0}, 2};
          },
          [](const AprilGrid& b) {
            const double cell = b.tag_m / kTagCells, gap = b.spacing * kTagCells;
            const auto across = [&](int tags) {
              return tags * kTagCells + (tags - 1) * gap + 2 * (gap + kTagBorderCells);
            };
            return CellGrid{{cell, cell}, {across(b.cols), across(b.rows)}, gap + kTagBorderCells};
          },
          [](const CharucoBoard& b) {  // squares, and half of one around
            const double cell = b.marker_m / TagFamilyOf(b.dictionary).border_cells;
            const double square = b.square_m / cell;
            return CellGrid{{cell, cell}, {(b.cols + 1) * square, (b.rows + 1) * square}, 1.5 * square};
          },
          [](const CircleGrid& b) {
            const double across = b.asymmetric ? 2 * b.cols - 1 : b.cols - 1;
            return CellGrid{{b.spacing_m, b.spacing_m}, {across + 3, b.rows + 2.0}, 1.5};
          }},
      board);
}

// The share of each pixel that a disc covers, by 16 x 16 points of those at its rim.
void DrawDiscs(const CircleGrid& board, const Rectangle& sheet, const Eigen::Vector2d& px_m, cv::Mat& black) {
  constexpr int kFine = 16;
  const double radius = board.diameter_m / 2;
  for (const Eigen::Vector2d& middle : Corners(board)) {
    const Eigen::Vector2d at = (middle - sheet.low).cwiseQuotient(px_m);
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(radius).cwiseQuotient(px_m);
    for (int row = std::max(0, static_cast<int>(at.y() - reach.y()));
         row <= at.y() + reach.y() && row < black.rows; ++row) {
      for (int col = std::max(0, static_cast<int>(at.x() - reach.x()));
           col <= at.x() + reach.x() && col < black.cols; ++col) {
        int inside = 0;
        for (int i = 0; i < kFine * kFine; ++i) {
          const Eigen::Vector2d point(col + (i % kFine + 0.5) / kFine, row + (i / kFine + 0.5) / kFine);
          inside += (point - at).cwiseProduct(px_m).squaredNorm() < radius * radius;
        }
        black.at<float>(black.rows - 1 - row, col) += static_cast<float>(inside) / (kFine * kFine);
      }
    }
  }
}

}  // namespace

std::vector<Rectangle> BlackRectangles(const Board& board) {
  std::vector<Rectangle> black;
  std::visit(
      Overloaded{
          [&](const Chessboard& b) {
            for (int row = -1; row < b.rows; ++row) {
              for (int col = -1; col < b.cols; ++col) {
                if ((row + col) % 2 != 0) continue;
                black.push_back({{col * b.col_m, row * b.row_m},  //
                                 {(col + 1) * b.col_m, (row + 1) * b.row_m}});
              }
            }
          },
          [&](const AprilGrid& b) {
            const double pitch = (1 + b.spacing) * b.tag_m, gap = b.spacing * b.tag_m;
            const double cell = b.tag_m / kTagCells;
            for (int row = 0; row <= b.rows; ++row) {
              for (int col = 0; col <= b.cols; ++col) {
                const Eigen::Vector2d tag(col * pitch, row * pitch);
                black.push_back({tag - Eigen::Vector2d(gap, gap), tag});
                if (row == b.rows || col == b.cols) continue;
                const std::uint64_t code = TagCode(row * b.cols + col);
                for (int down = 0; down < kTagCells; ++down) {
                  for (int right = 0; right < kTagCells; ++right) {
                    const int i = down - kTagBorderCells, j = right - kTagBorderCells;
                    const bool inside = i >= 0 && i < kTagCodeCells && j >= 0 && j < kTagCodeCells;
                    if (inside && code >> (kTagCodeCells * kTagCodeCells - 1 - kTagCodeCells * i - j) & 1)
                      continue;
                    const Eigen::Vector2d low = tag + cell * Eigen::Vector2d(right, kTagCells - 1 - down);
                    black.push_back({low, low + Eigen::Vector2d(cell, cell)});
                  }
                }
              }
            }
          },
          [&](const CharucoBoard& b) {
            for (int row = 0; row < b.rows; ++row) {
              for (int col = 0; col < b.cols; ++col) {
                if (((row + col) % 2 == 0) != BlackLowerLeft(b)) continue;
                black.push_back(
                    {b.square_m * Eigen::Vector2d(col - 1, row - 1), b.square_m * Eigen::Vector2d(col, row)});
              }
            }
            const TagFamily family = TagFamilyOf(b.dictionary);
            const int around = (family.total_cells - family.border_cells) / 2;
            const double cell = b.marker_m / family.border_cells;
            for (const CharucoMarker& marker : Markers(b)) {
              const cv::Mat cells = CellsOfTag(family, marker.id);
              for (int down = 0; down < family.border_cells; ++down) {
                for (int right = 0; right < family.border_cells; ++right) {
                  if (cells.at<std::uint8_t>(down + around, right + around) != kBlackCell) continue;
                  const Eigen::Vector2d low =
                      marker.low + cell * Eigen::Vector2d(right, family.border_cells - 1 - down);
                  black.push_back({low, low + Eigen::Vector2d(cell, cell)});
                }
              }
            }
          },
          [](const CircleGrid&) {}},
      board);
  return black;
}

Rectangle Sheet(const Board& board) {
  const CellGrid grid = Cells(board);
  const Eigen::Vector2d low = -grid.before * grid.cell_m;
  return {low, low + grid.cells.cwiseProduct(grid.cell_m)};
}

BoardPicture DrawBoard(const Board& board, int side_px) {
  const CellGrid grid = Cells(board);
  // Pixels of a cell, and of white beyond the sheet: whole numbers, so that edges fall between pixels; and
  // where there is room, divisible by 4, so that they do so too when a renderer halves the picture twice.
  Eigen::Vector2d cell_px, beyond_px;
  for (int axis = 0; axis < 2; ++axis) {
    const double most = side_px / grid.cells[axis], step = most < 16 ? 1 : 4;
    cell_px[axis] = std::floor(most / step) * step;
    beyond_px[axis] = std::floor((side_px - cell_px[axis] * grid.cells[axis]) / 2 / step) * step;
  }
  const Eigen::Vector2d px_m = grid.cell_m.cwiseQuotient(cell_px);
  BoardPicture picture;
  picture.sheet.low = Sheet(board).low - beyond_px.cwiseProduct(px_m);
  picture.sheet.high = picture.sheet.low + side_px * px_m;

  // The black that covers each pixel, 0 to 1, along rows of the sheet from below.
  cv::Mat black(side_px, side_px, CV_32FC1, cv::Scalar(0));
  for (const Rectangle& r : BlackRectangles(board)) {
    const Eigen::Vector2d low = (r.low - picture.sheet.low).cwiseQuotient(px_m);
    const Eigen::Vector2d high = (r.high - picture.sheet.low).cwiseQuotient(px_m);
    const auto covered = [&](int axis, int pixel) {
      return static_cast<float>(
          std::clamp(std::min(high[axis], pixel + 1.0) - std::max(low[axis], double(pixel)), 0.0, 1.0));
    };
    const int last_row = std::min(side_px - 1, static_cast<int>(high.y()));
    const int last_col = std::min(side_px - 1, static_cast<int>(high.x()));
    for (int row = std::max(0, static_cast<int>(low.y())); row <= last_row; ++row) {
      for (int col = std::max(0, static_cast<int>(low.x())); col <= last_col; ++col)
        black.at<float>(side_px - 1 - row, col) += covered(0, col) * covered(1, row);
    }
  }
  if (const CircleGrid* circles = std::get_if<CircleGrid>(&board))
    DrawDiscs(*circles, picture.sheet, px_m, black);
  black.convertTo(picture.grey, CV_8U, -255, 255);
  return picture;
}

#ifdef KESTREL_WITHOUT_APRILTAG
std::uint64_t TagCode(int) { return 0; }  // boards of tags were refused
#else
std::uint64_t TagCode(int id) {
  static const std::vector<std::uint64_t> codes = [] {
    // The library counts a code's bits along its own way through the cells, with a border of one.
    apriltag_family_t* const family = tag36h11_create();
    std::vector<std::uint64_t> all;
    for (std::uint32_t i = 0; i < family->ncodes; ++i) {
      std::uint64_t code = 0;
      for (std::uint32_t bit = 0; bit < family->nbits; ++bit) {
        const std::uint64_t white = family->codes[i] >> (family->nbits - 1 - bit) & 1;
        const std::uint32_t cell = (family->bit_y[bit] - 1) * kTagCodeCells + family->bit_x[bit] - 1;
        code |= white << (family->nbits - 1 - cell);
      }
      all.push_back(code);
    }
    tag36h11_destroy(family);
    return all;
  }();
  return codes[static_cast<std::size_t>(id)];
}
#endif

}  // namespace kestrel::vision
