// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibrate.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/diagnostics.h"
#include "tests/vision/calibration/board_photographer.h"
#include "vision/calibration/board_shape.h"
#include "vision/calibration/calibration_checks.h"
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
std::vector<BoardView> Views(const CameraModel& camera, const Board& board, int count, std::uint64_t seed,
                             const std::vector<Eigen::Vector3d>& offsets = {}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kNoise_px);
  const std::vector<Eigen::Vector2d> corners = Corners(board);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const Pose X_CT = ScatteredPose(camera, board, random);
    BoardView view{fmt::format("image {}", i), {}};
    for (std::size_t j = 0; j < corners.size(); ++j) {
      Eigen::Vector3d p_T(corners[j].x(), corners[j].y(), 0);
      if (!offsets.empty()) p_T += offsets[j];
      const auto uv = Project(camera, X_CT * p_T);
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

// A print that is bowed by 1.5 mm and has its corners 0.1 mm off.
std::vector<Eigen::Vector3d> Uneven(const Board& board, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> uneven(0, 1e-4);
  std::vector<Eigen::Vector3d> offsets;
  for (const Eigen::Vector2d& p : Corners(board)) {
    const double across = p.x() / Corners(board).back().x();
    offsets.emplace_back(uneven(random), uneven(random), 6e-3 * across * (1 - across));
  }
  return offsets;
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
              AllOf(HasSubstr("0.8 px are accepted"), HasSubstr("worst: image "), HasSubstr("spacing")));
  // Who knows better may have it, with the board as the images show it.
  const Calibration c = Calibrate(board, views, CameraLike("pinhole", {640, 480}), 100);
  EXPECT_GT(RmsOf(c.board).x(), 1e-3);
}

bool SaysContradiction(const Calibration& c) {
  return std::any_of(c.notes.begin(), c.notes.end(),
                     [](const std::string& note) { return note.find("contradict") != std::string::npos; });
}

TEST(Calibrate, SaysThatImagesOfTwoCamerasContradictEachOther) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    std::vector<BoardView> views = Views(Narrow(600), Chessboard{}, 8, seed);
    const Calibration one = Calibrate(Chessboard{}, views, CameraLike("pinhole", {640, 480}));
    EXPECT_FALSE(SaysContradiction(one));
    for (BoardView& view : Views(Narrow(630), Chessboard{}, 8, seed + 10)) views.push_back(std::move(view));
    const Calibration mixed = Calibrate(Chessboard{}, views, CameraLike("pinhole", {640, 480}));
    EXPECT_THAT(mixed.notes, Contains(HasSubstr("the images contradict each other")));
  }
}

TEST(Calibrate, SaysThatABoardSeldomFoundMayBeAnother) {
  const BrownConrady camera = Narrow(500);
  const Board board;
  std::vector<BoardView> views = Views(camera, board, 12, 43);
  const auto says = HasSubstr("the board was found in 12 of");
  const auto none = [](int number) { return BoardView{fmt::format("none {}", number), {}}; };
  for (int i = 0; i < 24; ++i) views.push_back(none(i));
  EXPECT_THAT(Calibrate(board, views, camera).notes, Not(Contains(says)));
  views.push_back(none(24));
  EXPECT_THAT(Calibrate(board, views, camera).notes.front(), says);
}

TEST(Calibrate, LeavesOutTheOneImageThatContradictsTheOthers) {
  int left_out = 0;
  for (std::uint64_t seed = 21; seed <= 26; ++seed) {
    std::vector<BoardView> views = Views(Narrow(600), Chessboard{}, 14, seed);
    views.insert(views.begin() + 5, Views(Narrow(612), Chessboard{}, 1, seed + 10)[0]);
    views[5].name = "refocused";
    const Calibration c = Calibrate(Chessboard{}, views, CameraLike("pinhole", {640, 480}));
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (i != 5) {
        EXPECT_EQ(c.views[i].left_out, "") << seed;
      }
    }
    if (c.views[5].left_out.empty()) continue;  // a board that faces the camera tells nothing of it
    EXPECT_THAT(c.notes, Contains(HasSubstr("refocused was left out")));
    left_out += c.views[5].left_out.find("contradicts the others") != std::string::npos;
  }
  EXPECT_GE(left_out, 2);
}

TEST(Calibrate, SaysNothingOfContradictionsInGoodSets) {
  int sets = 0;
  for (std::uint64_t seed = 31; seed <= 36; ++seed) {
    for (const bool uneven : {false, true}) {
      const auto offsets = uneven ? Uneven(Chessboard{}, seed) : std::vector<Eigen::Vector3d>{};
      const Calibration c = Calibrate(Chessboard{}, Views(Narrow(700), Chessboard{}, 12, seed, offsets),
                                      CameraLike("pinhole", {640, 480}));
      EXPECT_FALSE(SaysContradiction(c)) << seed;
      ++sets;
    }
  }
  EXPECT_EQ(sets, 12);
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

TEST(Calibrate, KnowsTheLensThoughTheBoardIsBentAndUneven) {
  int flat = 0;
  for (std::uint64_t seed = 41; seed < 45; ++seed) {
    const Chessboard board;
    const auto offsets = Uneven(board, seed);
    const Calibration c =
        Calibrate(board, Views(Narrow(600), board, 16, seed, offsets), CameraLike("pinhole", {640, 480}));
    ASSERT_EQ(c.board.offsets_m.size(), offsets.size()) << seed;
    EXPECT_LT(c.rms_px, 1.2 * std::sqrt(2) * kNoise_px) << seed;
    EXPECT_NEAR(Parameters(c.camera)[0], 600, 4 * c.sigma[0]) << seed;
    EXPECT_LT(c.sigma[0], 1) << seed;
    EXPECT_THAT(c.notes, Contains(HasSubstr("not quite as its file says"))) << seed;
    const Calibration of_flat =
        Calibrate(board, Views(Narrow(600), board, 16, seed), CameraLike("pinhole", {640, 480}));
    flat += of_flat.board.offsets_m.empty();
  }
  EXPECT_EQ(flat, 4);
}

TEST(Calibrate, HoldsTheDistortionThatNarrowViewsDoNotShow) {
  for (const std::string model : {"pinhole", "fisheye", "unified"}) {
    const std::vector<BoardView> views = Views(Narrow(1500), Chessboard{}, 12, 51);
    const Calibration c = Calibrate(Chessboard{}, views, CameraLike(model, {640, 480}));
    EXPECT_LE(c.free.size(), 5u) << model;  // of a fisheye k1 makes it a pinhole, of a unified camera xi may
    EXPECT_THAT(c.notes, Contains(HasSubstr("held at 0"))) << model;
    EXPECT_NEAR(c.rms_px, std::sqrt(2) * kNoise_px, 0.01) << model;
    EXPECT_LT(c.worst_uncertainty_px, 0.5) << model;
  }
}

TEST(Calibrate, FindsTheDistortionThatIsThere) {
  BrownConrady camera = Narrow(500);
  camera.k1 = -0.2, camera.k2 = 0.05, camera.p1 = 1e-3, camera.p2 = -1e-3;
  const Calibration c =
      Calibrate(Chessboard{}, Views(camera, Chessboard{}, 16, 61), CameraLike("pinhole", {640, 480}));
  EXPECT_EQ(c.free.size(), 8u);
  EXPECT_THAT(c.notes, Not(Contains(HasSubstr("held at 0"))));
}

TEST(AcceptedResidual, GrowsWithTheImageAndWithItsBlur) {
  BoardView view{"image", std::vector<BoardCorner>(9)};
  for (BoardCorner& corner : view.corners) corner.blur_px = 0.4;
  EXPECT_DOUBLE_EQ(AcceptedResidual(std::vector{view}, CameraLike("pinhole", {640, 480})), 0.8);
  EXPECT_DOUBLE_EQ(AcceptedResidual(std::vector{view}, CameraLike("pinhole", {1600, 1200})), 2);
  for (BoardCorner& corner : view.corners) corner.blur_px = 1.4;
  EXPECT_DOUBLE_EQ(AcceptedResidual(std::vector{view}, CameraLike("pinhole", {640, 480})), 1.6);
}

// Against the spread over many draws, with the board free and expected to be off by what it is.
TEST(ParameterCovariance, HoldsWhereTheBoardIsFree) {
  constexpr int kTrials = 60, kViews = 8;
  const std::vector<int> free = {0, 1, 2, 3};
  const Pinhole truth{640, 480, 600, 600, 319.5, 239.5};
  const std::vector<Eigen::Vector2d> corners = Corners(Chessboard{5, 4, 0.08, 0.08});
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double square = 0, expected = 0, determined = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Adjustment a{
        truth, {}, {std::vector<Eigen::Vector3d>(corners.size(), Eigen::Vector3d::Zero()), 3e-4, 1e-3}};
    std::vector<Eigen::Vector3d> offsets;
    for (std::size_t i = 0; i < corners.size(); ++i)
      offsets.emplace_back(3e-4 * normal(random), 3e-4 * normal(random), 1e-3 * normal(random));
    for (int i = 0; i < kViews; ++i) {
      AdjustedView view{ScatteredPose(truth, Chessboard{5, 4, 0.08, 0.08}, random), {}};
      for (std::size_t j = 0; j < corners.size(); ++j) {
        const Eigen::Vector3d p_T(corners[j].x(), corners[j].y(), 0);
        const auto uv = Project(truth, view.X_CT * (p_T + offsets[j]));
        const Eigen::Vector2d noise(normal(random), normal(random));
        view.points.push_back({p_T, uv.value() + kNoise_px * noise, Eigen::Matrix2d::Identity() / kNoise_px,
                               static_cast<int>(j)});
      }
      a.views.push_back(std::move(view));
    }
    Adjust(a, {.free = free});
    square += std::pow(Parameters(a.camera)[0] - 600, 2) / kTrials;
    expected += (*ParameterCovariance(a, free))(0, 0) / kTrials;
    determined += DeterminedOffsets(a, free).sum() / kTrials;
  }
  EXPECT_NEAR(std::sqrt(expected / square), 1, 0.25);
  EXPECT_LT(determined, 3.0 * static_cast<double>(corners.size()) - 6);  // a turn, a shift, a scale
  EXPECT_GT(determined, 2.0 * static_cast<double>(corners.size()));
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
      view.points.push_back(
          {Eigen::Vector3d(p.x(), p.y(), 0), uv.value(), Eigen::Matrix2d::Identity() / kNoise_px});
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
