// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibrate.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "base/diagnostics.h"
#include "tests/vision/calibration/board_photographer.h"
#include "vision/calibration/view_adjustment.h"
#include "vision/camera/brown_conrady.h"
#include "vision/camera/pinhole.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNoise_px = 0.05;

BrownConrady Narrow(double f) {
  BrownConrady c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = f, c.cx = 319.5, c.cy = 239.5;
  return c;
}

// Where a camera sees the corners of a board, with noise.
std::vector<BoardView> Views(const CameraModel& camera, const Board& board, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kNoise_px);
  const std::vector<Eigen::Vector2d> corners = Corners(board);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const Pose X_CT = ScatteredPose(camera, board, random);
    BoardView view{fmt::format("image {}", i), {}};
    for (std::size_t j = 0; j < corners.size(); ++j) {
      const auto uv = Project(camera, X_CT * Eigen::Vector3d(corners[j].x(), corners[j].y(), 0));
      if (!uv || uv->x() < 0 || uv->y() < 0 || uv->x() > WidthPx(camera) - 1 ||
          uv->y() > HeightPx(camera) - 1)
        continue;
      view.corners.push_back({static_cast<int>(j), *uv + Eigen::Vector2d(noise(random), noise(random)),
                              kNoise_px * kNoise_px * Eigen::Matrix2d::Identity()});
    }
    views.push_back(std::move(view));
  }
  return views;
}

std::string Refusal(const Board& board, const std::vector<BoardView>& views, const std::string& model) {
  try {
    Calibrate(board, views, CameraLike(model, {640, 480}));
  } catch (const InputError& e) {
    return e.what();
  }
  return "none";
}

TEST(Calibrate, RefusesABoardWhoseNumbersAreWrong) {
  AprilGrid board;
  const std::vector<BoardView> views = Views(Narrow(600), board, 12, 1);
  EXPECT_LT(Calibrate(board, views, CameraLike("pinhole", {640, 480})).rms_px, 0.1);
  board.spacing *= 0.9;
  EXPECT_THAT(Refusal(board, views, "pinhole"),
              AllOf(HasSubstr("0.5 px are accepted"), HasSubstr("worst: image "), HasSubstr("spacing")));
  // Who knows better may have it.
  EXPECT_GT(Calibrate(board, views, CameraLike("pinhole", {640, 480}), 100).rms_px, 0.5);
}

TEST(Calibrate, SaysThatImagesOfTwoCamerasContradictEachOther) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    std::vector<BoardView> views = Views(Narrow(600), Chessboard{}, 8, seed);
    const auto contradiction = Contains(HasSubstr("contradict"));
    const Calibration one = Calibrate(Chessboard{}, views, CameraLike("pinhole", {640, 480}));
    EXPECT_THAT(one.notes, Not(contradiction));
    for (BoardView& view : Views(Narrow(630), Chessboard{}, 8, seed + 10)) views.push_back(std::move(view));
    const Calibration mixed = Calibrate(Chessboard{}, views, CameraLike("pinhole", {640, 480}));
    EXPECT_THAT(mixed.notes, contradiction);
    EXPECT_GT(mixed.sigma[0], 2 * one.sigma[0]);
  }
}

TEST(Calibrate, RefusesACameraOfSomeOfTheImagesOnly) {
  std::vector<BoardView> views = Views(Narrow(600), Chessboard{}, 8, 1);
  std::mt19937_64 random(1);
  for (int i = 0; i < 5; ++i) {  // corners in an order that no camera makes
    BoardView wrong = views[static_cast<std::size_t>(i)];
    for (BoardCorner& corner : wrong.corners)
      corner.pixel += Eigen::Vector2d::Constant(std::uniform_real_distribution<double>(-40, 40)(random));
    wrong.name = fmt::format("wrong {}", i);
    views.push_back(std::move(wrong));
  }
  EXPECT_THAT(Refusal(Chessboard{}, views, "pinhole"),
              AllOf(HasSubstr("5 of 13 images do not fit"), HasSubstr("wrong 0, wrong 1"),
                    HasSubstr("another camera")));
}

TEST(Calibrate, RefusesParametersThatTheImagesLeaveOpen) {
  const std::vector<BoardView> views = Views(Narrow(300), Chessboard{}, 16, 5);
  EXPECT_EQ(Refusal(Chessboard{}, views, "pinhole"), "none");
  EXPECT_THAT(Refusal(Chessboard{}, views, "double_sphere"),
              AllOf(HasSubstr("do not determine the double_sphere model: fx "), HasSubstr("+-"),
                    HasSubstr("take the model pinhole")));
}

// Against the definition: the spread over many draws of errors that are alike within a view, there a change
// of scale.
TEST(ClusteredCovariance, HoldsForErrorsThatAreAlikeWithinAView) {
  constexpr int kTrials = 60, kViews = 24;
  const std::vector<int> free = {0, 1, 2, 3};
  const Pinhole truth{640, 480, 600, 600, 319.5, 239.5};
  const std::vector<Eigen::Vector2d> corners = Corners(Chessboard{});
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Adjustment exact{truth, {}};
  for (int i = 0; i < kViews; ++i) {
    AdjustedView view{ScatteredPose(exact.camera, Chessboard{}, random), {}};
    for (const Eigen::Vector2d& p : corners) {
      const auto uv = Project(exact.camera, view.X_CT * Eigen::Vector3d(p.x(), p.y(), 0));
      view.points.push_back({p, uv.value(), Eigen::Matrix2d::Identity() / kNoise_px});
    }
    exact.views.push_back(std::move(view));
  }
  double error_square = 0, clustered = 0, independent = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Adjustment a = exact;
    for (AdjustedView& view : a.views) {
      const Eigen::Vector2d middle(319.5, 239.5);
      const double stretch = 2e-3 * normal(random);
      for (SeenPoint& point : view.points)
        point.pixel += Eigen::Vector2d(stretch * (point.pixel - middle).x(), 0) +
                       0.1 * kNoise_px * Eigen::Vector2d(normal(random), normal(random));
    }
    Adjust(a, {.free = free});
    error_square += std::pow(Parameters(a.camera)[0] - 600, 2) / kTrials;
    clustered += (*ClusteredCovariance(a, free))(0, 0) / kTrials;
    double freedom = -4 - 6.0 * kViews;
    for (const AdjustedView& view : a.views) freedom += 2.0 * static_cast<double>(view.points.size());
    const double cost = CostOf(a, std::numeric_limits<double>::infinity());
    independent += (*ParameterCovariance(a, free))(0, 0) * cost / freedom / kTrials;
  }
  EXPECT_NEAR(std::sqrt(clustered / error_square), 1, 0.3);
  EXPECT_LT(std::sqrt(independent / error_square), 0.6);
}

}  // namespace
}  // namespace kestrel::vision
