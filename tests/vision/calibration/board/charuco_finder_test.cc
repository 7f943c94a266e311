// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/charuco_finder.h"

#include <gtest/gtest.h>

#include <opencv2/aruco/charuco.hpp>

#include "tests/vision/calibration/board/board_set.h"
#include "vision/camera/brown_conrady.h"
#include "vision/camera/kannala_brandt.h"

namespace kestrel::vision {
namespace {

cv::Mat DrawnByOpenCv(const CharucoBoard& b, int dictionary, int square_px) {
  cv::Mat grey;
  const cv::Size size(b.cols * square_px, b.rows * square_px);
  const float square = static_cast<float>(b.square_m), marker = static_cast<float>(b.marker_m);
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
  const cv::aruco::CharucoBoard board({b.cols, b.rows}, square, marker,
                                      cv::aruco::getPredefinedDictionary(dictionary));
  board.generateImage(size, grey, 0, 1);
#else
  const auto board = cv::aruco::CharucoBoard::create(b.cols, b.rows, square, marker,
                                                     cv::aruco::getPredefinedDictionary(dictionary));
  board->draw(size, grey, 0, 1);
#endif
  return grey;
}

TEST(FindCharuco, FindsTheBoardsThatOpenCvDraws) {
  constexpr int kSquare = 40, kBorder = 30;
  for (const auto& [board, dictionary] :
       {std::pair{CharucoBoard{6, 9, 0.04, 0.028, "DICT_4X4_50"}, cv::aruco::DICT_4X4_50},
        {CharucoBoard{7, 8, 0.04, 0.028, "DICT_5X5_100"}, cv::aruco::DICT_5X5_100}}) {
    cv::Mat grey;
    cv::copyMakeBorder(DrawnByOpenCv(board, dictionary, kSquare), grey, kBorder, kBorder, kBorder, kBorder,
                       cv::BORDER_CONSTANT, cv::Scalar(255));
    cv::GaussianBlur(grey, grey, {}, 0.7);
    const std::vector<BoardCorner> corners = FindBoard(grey, board);
    EXPECT_EQ(corners.size(), static_cast<std::size_t>((board.cols - 1) * (board.rows - 1)));
    for (const BoardCorner& corner : corners) {
      const int col = corner.index % (board.cols - 1), row = corner.index / (board.cols - 1);
      const Eigen::Vector2d truth(kBorder + (col + 1) * kSquare - 0.5,
                                  kBorder + (board.rows - 1 - row) * kSquare - 0.5);
      EXPECT_LT((corner.pixel - truth).norm(), 0.1) << corner.index;
    }
  }
}

TEST(FindCharuco, CalibratesALensFromBoardsThatAreSeenInPart) {
  const CharucoBoard board{7, 10, 0.03, 0.022, "DICT_4X4_50"};
  KannalaBrandt fisheye;
  fisheye.width_px = 640, fisheye.height_px = 480;
  fisheye.fx = fisheye.fy = 215, fisheye.cx = 316, fisheye.cy = 243, fisheye.k1 = 0.02;
  BrownConrady narrow;
  narrow.width_px = 640, narrow.height_px = 480;
  narrow.fx = narrow.fy = 560, narrow.cx = 322, narrow.cy = 236, narrow.k1 = -0.2;
  for (const CameraModel& camera : {CameraModel(fisheye), CameraModel(narrow)}) {
    const BoardSet set = PhotographSet(camera, board, 10, 81);
    std::size_t least = 1000;
    for (const BoardView& view : set.views) least = std::min(least, view.corners.size());
    EXPECT_LT(least, Corners(board).size());
    EXPECT_LT(CornerError(camera, board, set, set.views), 0.1);
    const std::string model = std::holds_alternative<KannalaBrandt>(camera) ? "fisheye" : "pinhole";
    const Calibration c = CalibrateSet(board, set, CameraLike(model, {640, 480}));
    EXPECT_GE(c.corners, 200);
    const Eigen::VectorXd error = Parameters(c.camera).head<4>() - Parameters(camera).head<4>();
    for (int i = 0; i < 4; ++i) EXPECT_LT(std::abs(error[i]), 4 * c.sigma[i]) << model << ' ' << i;
    EXPECT_LT(c.sigma.head<4>().maxCoeff(), 0.2) << model;
  }
}

}  // namespace
}  // namespace kestrel::vision
