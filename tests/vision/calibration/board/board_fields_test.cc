// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "vision/calibration/board/board.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Board Loaded(const std::string& text, std::string& wrong) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "board_fields_test.yaml";
  std::ofstream(file) << text;
  Mistakes mistakes;
  const Board board = LoadBoard(file, mistakes);
  try {
    mistakes.ThrowIfAny();
  } catch (const InputError& e) {
    wrong = e.what();
  }
  return board;
}

TEST(LoadBoard, ReadsWhatItWrites) {
  int boards = 0;
  for (const Board& board : {Board(Chessboard{7, 5, 0.03, 0.031}), Board(AprilGrid{4, 3, 0.05, 0.25}),
                             Board(CharucoBoard{6, 9, 0.04, 0.028, "DICT_4X4_50", true}),
                             Board(CircleGrid{4, 11, 0.02, 0.015, true})}) {
    std::string wrong;
    const Board read = Loaded(ToKalibr(board), wrong);
    EXPECT_EQ(wrong, "");
    EXPECT_EQ(Describe(read), Describe(board));
    EXPECT_EQ(Corners(read), Corners(board));
    EXPECT_EQ(read.index(), board.index());
    boards += 1;
  }
  EXPECT_EQ(boards, 4);
}

TEST(LoadBoard, RefusesBoardsThatCannotBe) {
  std::string wrong;
  Loaded(ToKalibr(CharucoBoard{6, 9, 0.03, 0.04, "DICT_4X4_50"}), wrong);
  EXPECT_THAT(wrong, AllOf(HasSubstr("markerSize"), HasSubstr("valid: ")));
  Loaded(ToKalibr(CharucoBoard{20, 20, 0.03, 0.02, "DICT_4X4_50"}), wrong);
  EXPECT_THAT(wrong, AllOf(HasSubstr("200 markers"), HasSubstr("DICT_4X4_50 has 50")));
  Loaded(ToKalibr(CircleGrid{7, 6, 0.02, 0.02, false}), wrong);
  EXPECT_THAT(wrong, HasSubstr("would touch"));
  Loaded("target_type: 'chaurco'\n", wrong);
  EXPECT_THAT(wrong, HasSubstr("valid: checkerboard, aprilgrid, charuco, circlegrid"));
}

}  // namespace
}  // namespace kestrel::vision
