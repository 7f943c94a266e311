// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/board.h"

#ifndef KESTREL_WITHOUT_APRILTAG
#include <apriltag/tag36h11.h>
#endif
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/overloaded.h"
#include "base/yaml/fields.h"
#include "base/yaml/yaml_fields.h"
#include "vision/calibration/board/tag_36h11.h"

namespace kestrel::vision {
namespace {

// What both boards are made of: cells between which every edge falls, and the sheet counted in them. The
// lowest corner has `before` cells to its left, and as many below it.
struct CellGrid {
  Eigen::Vector2d cell_m;
  Eigen::Vector2d cells;  // along x and y of the sheet
  double before = 0;
};

CellGrid Cells(const Board& board) {
  return std::visit(
      Overloaded{[](const Chessboard& b) {
                   return CellGrid{{b.col_m, b.row_m}, {b.cols + 3.0, b.rows + 3.0}, 2};
                 },
                 [](const AprilGrid& b) {
                   const double cell = b.tag_m / kTagCells, gap = b.spacing * kTagCells;
                   const auto across = [&](int tags) {
                     return tags * kTagCells + (tags - 1) * gap + 2 * (gap + kTagBorderCells);
                   };
                   return CellGrid{{cell, cell}, {across(b.cols), across(b.rows)}, gap + kTagBorderCells};
                 }},
      board);
}

// The file's form of either board.
struct TargetFile {
  std::string target_type;
  Chessboard chessboard;
  AprilGrid april_grid;
};

void Fields(FieldVisitor& v, TargetFile& f) {
  v(Required("target_type", "kind of calibration board, as in a target file of Kalibr"), f.target_type,
    {"checkerboard", "aprilgrid"});
  if (f.target_type != "aprilgrid") {
    v(Required("targetCols", "inner corners in a row of the chessboard"), f.chessboard.cols, 3, 100);
    v(Required("targetRows", "inner corners in a column of the chessboard"), f.chessboard.rows, 3, 100);
    v(Required("colSpacingMeters", "distance between the corners of a row"), f.chessboard.col_m, 1e-4, 10.0);
    v(Required("rowSpacingMeters", "distance between the rows of corners"), f.chessboard.row_m, 1e-4, 10.0);
  }
  if (f.target_type != "checkerboard") {
    v(Required("tagCols", "number of AprilTags in a row"), f.april_grid.cols, 1, 100);
    v(Required("tagRows", "number of AprilTags in a column"), f.april_grid.rows, 1, 100);
    v(Required("tagSize", "side of a tag's black square, in m"), f.april_grid.tag_m, 1e-4, 10.0);
    v(Required("tagSpacing", "gap between two tags over the side of a tag"), f.april_grid.spacing, 0.1, 2.0);
  }
}

}  // namespace

Eigen::Vector2i CornerGrid(const Board& board) {
  return std::visit(Overloaded{[](const Chessboard& b) { return Eigen::Vector2i(b.cols, b.rows); },
                               [](const AprilGrid& b) { return Eigen::Vector2i(2 * b.cols, 2 * b.rows); }},
                    board);
}

std::vector<Eigen::Vector2d> Corners(const Board& board) {
  const Eigen::Vector2i grid = CornerGrid(board);
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < grid.y(); ++row) {
    for (int col = 0; col < grid.x(); ++col) {
      corners.push_back(std::visit(
          Overloaded{[&](const Chessboard& b) { return Eigen::Vector2d(col * b.col_m, row * b.row_m); },
                     [&](const AprilGrid& b) {
                       const auto along = [&](int i) {  // i / 2 tags and gaps, and for odd ones a tag
                         return (i / 2 * (1 + b.spacing) + i % 2) * b.tag_m;
                       };
                       return Eigen::Vector2d(along(col), along(row));
                     }},
          board));
    }
  }
  return corners;
}

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
          }},
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

Board LoadBoard(const std::filesystem::path& file, Mistakes& mistakes) {
  const Config config = LoadConfig(file, {}, mistakes);
  TargetFile target;
  for (const auto& [key, node] : config.root.members) {
    // Of a board that is not known, no other key can be judged.
    if (key == "target_type" && node.kind == ConfigNode::Kind::kText && node.text != "checkerboard" &&
        node.text != "aprilgrid") {
      mistakes.Add(node.where, key, fmt::format("'{}' is not valid", node.text),
                   "valid: checkerboard, aprilgrid");
      return {};
    }
  }
  Read(config, target, mistakes);
  if (target.target_type != "aprilgrid") return target.chessboard;
  const AprilGrid& grid = target.april_grid;
#ifdef KESTREL_WITHOUT_APRILTAG
  mistakes.Add(file.string(), "target_type",
               "aprilgrid, and this build has no AprilTag; valid: checkerboard, or build anew with Debian's "
               "libapriltag-dev");
#endif
  if (grid.cols * grid.rows > kTagCount) {
    mistakes.Add(config.root.where.file.empty() ? Place(file.string()) : config.root.where, "tagCols",
                 fmt::format("{} x {} tags are more than the {} of the family 36h11", grid.cols, grid.rows,
                             kTagCount));
  }
  return grid;
}

std::string ToKalibr(const Board& board) {
  TargetFile target;
  std::visit(Overloaded{[&](const Chessboard& b) {
                          target.target_type = "checkerboard";
                          target.chessboard = b;
                        },
                        [&](const AprilGrid& b) {
                          target.target_type = "aprilgrid";
                          target.april_grid = b;
                        }},
             board);
  return ToYaml(target);
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
                 }},
      board);
}

}  // namespace kestrel::vision
