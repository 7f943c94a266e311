// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

// Families of square tags: those of AprilTag 3 (Krogius, Haggenmiller, Olson 2019) and the dictionaries of ArUco.
namespace kestrel::vision {

// What stands in a cell of a tag. Of a hole, a cell that nobody reads, it does not matter: a smaller tag may lie
// there.
enum TagCell : std::uint8_t { kBlackCell = 0, kHoleCell = 128, kWhiteCell = 255 };

struct TagFamily {
  std::string name;
  int count = 0;                // ids are below it
  int total_cells = 0;          // along a side, with the white or coded cells that must be around the border
  int border_cells = 0;         // along a side of the square whose corners are detected
  bool reversed = false;        // that square is light within dark
  int distance = 0;             // cells in which any two codes differ, in any turn
  std::vector<cv::Point> bits;  // cells of the code, from the corner of that square; see Codes()
};

// The names that are known; without libapriltag none.
std::vector<std::string> TagFamilyNames();

// One of those names. Tables of thousands of codes are read for it: keep it.
TagFamily TagFamilyOf(const std::string& name);

// The code of a tag, a bit for each of `bits`, the first the highest; 1 is white. The bits are four times the same
// number, each quarter the one before turned clockwise by a right angle, and maybe the middle at last.
std::uint64_t TagCodeOf(const TagFamily& family, int id);

// A tag as it is drawn: total_cells x total_cells of TagCell, CV_8UC1.
cv::Mat CellsOfTag(const TagFamily& family, int id);

}  // namespace kestrel::vision
