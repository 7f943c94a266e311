// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/chessboard_finder.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/vision/calibration/board/board_set.h"
#include "vision/calibration/board/board_detector.h"
#include "vision/camera/brown_conrady.h"
#include "vision/camera/kannala_brandt.h"

namespace kestrel::vision {
namespace {

BrownConrady Webcam() {
  BrownConrady c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 560, c.cx = 319.5, c.cy = 239.5;
  return c;
}

KannalaBrandt FisheyeOf640() {
  KannalaBrandt c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 230, c.cx = 319.5, c.cy = 239.5;
  return c;
}

// The boards seen at random of which every corner was found where the camera sees it.
struct Count {
  int exact = 0, wrong = 0;
};
Count CountFound(const CameraModel& camera, const Chessboard& board, bool white_lower_left, int images,
                 std::uint64_t seed) {
  BoardPicture picture = DrawBoard(board, 1024);
  if (white_lower_left) cv::flip(picture.grey, picture.grey, 1);
  const std::vector<Eigen::Vector2d> places = Corners(board);
  std::mt19937_64 random(seed);
  Count count;
  for (int i = 0; i < images; ++i) {
    const Pose X_CT = ScatteredPose(camera, board, random);
    const cv::Mat image = PhotographBoard(camera, picture, X_CT, seed, {.fine = 2});
    const std::vector<BoardCorner> corners = FindBoard(image, board);
    if (corners.empty()) continue;
    // Some boards look the same upside down.
    double worst = 1e9;
    for (const bool half_turn : {false, true}) {
      double farthest = 0;
      for (const BoardCorner& corner : corners) {
        const std::size_t index = static_cast<std::size_t>(corner.index);
        const Eigen::Vector2d& p = places[half_turn ? places.size() - 1 - index : index];
        const auto uv = Project(camera, X_CT * Eigen::Vector3d(p.x(), p.y(), 0));
        farthest = std::max(farthest, uv ? (*uv - corner.pixel).norm() : 1e9);
      }
      worst = std::min(worst, farthest);
    }
    if (worst > 0.5)
      ++count.wrong;
    else
      count.exact += 2 * corners.size() > places.size();
  }
  return count;
}

TEST(FindBoard, FindsLargeBoardsWhicheverCornerIsBlack) {
  for (const bool white_lower_left : {false, true}) {
    const Count count = CountFound(Webcam(), {15, 9, 0.03, 0.03}, white_lower_left, 6, 71);
    EXPECT_GE(count.exact, 5);
    EXPECT_EQ(count.wrong, 0);
  }
}

TEST(FindBoard, FindsBoardsThroughAFisheye) {
  const Count count = CountFound(FisheyeOf640(), {9, 6, 0.03, 0.03}, false, 8, 72);
  EXPECT_GE(count.exact, 6);
  EXPECT_EQ(count.wrong, 0);
}

TEST(FindBoard, CalibratesAWideLensByALargeBoard) {
  const Chessboard board{15, 9, 0.03, 0.03};
  KannalaBrandt wide;
  wide.width_px = 960, wide.height_px = 720;
  wide.fx = wide.fy = 440, wide.cx = 483, wide.cy = 356, wide.k1 = 0.03, wide.k2 = -0.01;
  const BoardSet set = PhotographSet(wide, board, 10, 73);
  int found = 0;
  for (const BoardView& view : set.views) found += view.corners.size() > 100;
  EXPECT_GE(found, 9);
  const Calibration c = CalibrateSet(board, set, CameraLike("fisheye", {960, 720}));
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(std::abs(Parameters(c.camera)[i] - Parameters(wide)[i]), 4 * c.sigma[i]) << i;
    EXPECT_LT(c.sigma[i], 0.3) << i;
  }
}

// A flat board of squares of 40 px from (60, 60), and its corners.
cv::Mat FlatBoard(int cols, int rows) {
  cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(200));
  for (int r = 0; r <= rows; ++r) {
    for (int c = r % 2; c <= cols; c += 2) grey(cv::Rect(60 + 40 * c, 60 + 40 * r, 40, 40)).setTo(30);
  }
  return grey;
}
std::vector<Eigen::Vector2d> FlatCorners(int cols, int rows) {
  std::vector<Eigen::Vector2d> corners;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) corners.emplace_back(99.5 + 40 * c, 99.5 + 40 * r);
  }
  return corners;
}

TEST(IsChessboard, RefusesAGridThatIsNotTheBoards) {
  const cv::Mat grey = FlatBoard(9, 6);
  const std::vector<Eigen::Vector2d> right = FlatCorners(9, 6);
  EXPECT_TRUE(IsChessboard(grey, right, 9, 6));
  EXPECT_FALSE(IsChessboard(grey, right, 6, 9));
  std::vector<Eigen::Vector2d> one_off = right;
  one_off[20] += Eigen::Vector2d(25, 0);
  EXPECT_FALSE(IsChessboard(grey, one_off, 9, 6));
  std::vector<Eigen::Vector2d> exchanged = right;
  std::swap(exchanged[0], exchanged[1]);
  EXPECT_FALSE(IsChessboard(grey, exchanged, 9, 6));
  std::vector<Eigen::Vector2d> skipped = right;  // every second line
  for (Eigen::Vector2d& corner : skipped) corner.x() = 99.5 + 2 * (corner.x() - 99.5);
  EXPECT_FALSE(IsChessboard(grey, skipped, 9, 6));
}

}  // namespace
}  // namespace kestrel::vision
