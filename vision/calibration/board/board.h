// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"

// Flat boards to calibrate a camera by, described as Kalibr does. T is the board's frame: origin in the lower
// left corner, x right, y up, z out of the picture towards who looks at it. Corners count from 0 by rows, the
// lowest row first, each row from the left.
namespace kestrel::vision {

// cols x rows corners where four squares meet. The square at the lower left is drawn black; a printed board
// with a white one is found as well.
struct Chessboard {
  int cols = 9, rows = 6;
  double col_m = 0.05, row_m = 0.05;  // sides of a square along x and y
};

// cols x rows tags of the family 36h11, tag 0 at the lower left, counted by rows as corners are; upright,
// with a black border two cells wide. In the gaps between tags, and beside the outer ones, there are black
// squares that touch the tags' corners. Of each tag four corners count.
struct AprilGrid {
  int cols = 6, rows = 6;
  double tag_m = 0.088;  // side of a tag, border included
  double spacing = 0.3;  // gap between two tags over the side of a tag
};

// A chessboard of cols x rows squares with a marker of ArUco in the middle of each white one, counted by rows from the
// upper left, as OpenCV draws them. Its corners are those where four squares meet; any that are seen count.
struct CharucoBoard {
  int cols = 8, rows = 11;  // squares
  double square_m = 0.03, marker_m = 0.0225;
  std::string dictionary = "DICT_5X5_100";  // of vision/tag
  // The square at the upper left is black; in the pattern of OpenCV before 4.6 that at the lower left is instead,
  // which is another one where rows are even.
  bool legacy = false;
};
bool BlackLowerLeft(const CharucoBoard& board);

// cols x rows black discs, of which the middles count. Asymmetric: every second row, from the second on, is shifted by
// spacing_m, and circles of a row are twice that apart.
struct CircleGrid {
  int cols = 7, rows = 5;
  double spacing_m = 0.03;    // between rows
  double diameter_m = 0.018;  // of a disc
  bool asymmetric = false;
};

using Board = std::variant<Chessboard, AprilGrid, CharucoBoard, CircleGrid>;

// Corners in a row and in a column, and all of them in T by their index, m.
Eigen::Vector2i CornerGrid(const Board& board);
std::vector<Eigen::Vector2d> Corners(const Board& board);

// Sides from lower left to upper right, m.
struct Rectangle {
  Eigen::Vector2d low, high;
};

// A white square of a Charuco board: the lower left corner of its marker in T, m, and the marker's number.
struct CharucoMarker {
  int id = 0;
  Eigen::Vector2d low;
};
std::vector<CharucoMarker> Markers(const CharucoBoard& board);

// What must be seen of a board for it to be found: all of it, or some of its corners.
bool IsSeenWholeOnly(const Board& board);

// The side of what must be told apart to find it, m: of a square, a tag, a marker, a disc.
double DetailOf(const Board& board);

// Everything that is black on a board but discs, rectangles without overlap; and the sheet of white that holds it, with
// the margin that detectors need.
std::vector<Rectangle> BlackRectangles(const Board& board);
Rectangle Sheet(const Board& board);

// A board as a picture of side x side pixels, white 255, black 0: a sheet at least as large as Sheet, which
// is fitted so that the edges of squares, or of the cells of tags if their gap is of whole cells, fall
// between pixels.
struct BoardPicture {
  cv::Mat grey;     // CV_8UC1
  Rectangle sheet;  // what the picture covers, outer edges of its outer pixels
};
BoardPicture DrawBoard(const Board& board, int side_px = 2048);

// The code of a tag, row by row from the top left, the highest bit first; 1 is white.
std::uint64_t TagCode(int id);
inline constexpr int kTagCount = 587;

// A board as Kalibr's target file has it: target_type "checkerboard" with targetCols, targetRows,
// rowSpacingMeters and colSpacingMeters, "aprilgrid" with tagCols, tagRows, tagSize and tagSpacing, "circlegrid" with
// targetCols, targetRows, spacingMeters, asymmetricGrid and, of ours, circleDiameter; or, which Kalibr does not have,
// "charuco" with squareCols, squareRows, squareSize, markerSize, dictionary and legacyPattern.
Board LoadBoard(const std::filesystem::path& file, Mistakes& mistakes);
std::string ToKalibr(const Board& board);

// "chessboard of 11 x 8 corners, squares of 50 mm"
std::string Describe(const Board& board);

}  // namespace kestrel::vision
