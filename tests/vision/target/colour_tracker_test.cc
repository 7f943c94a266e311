// SPDX-License-Identifier: Apache-2.0
#include "vision/target/colour_tracker.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/vision/target/balloon_photographer.h"
#include "vision/target/balloon_fit.h"

namespace kestrel::vision {
namespace {

const Pinhole kCamera{320, 240, 250, 250, 159.5, 119.5};

class ColourTrackerTest : public ::testing::Test {
 protected:
  // What the tracker says of balls of 0.5 m with their centres there, in C.
  ColourTrack See(const std::vector<Eigen::Vector3d>& places) {
    PaintedBalls world;
    world.balls.clear();
    for (const auto& p : places) world.balls.push_back({.p_CT = p});
    return tracker_.Track(PaintBalls(kCamera, world, ++frame_));
  }
  static std::string Is(const ColourTrack& track) { return NameOf(track.state); }
  static Eigen::Vector2d At(const Eigen::Vector3d& p) { return *kCamera.Project(p); }

  ColourTracker tracker_{ColourModel(ColourRange{}), {}};
  int frame_ = 0;
};

TEST_F(ColourTrackerTest, ItFindsTheBallByItselfAndFollowsIt) {
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d p(-0.8 + 0.15 * k, 0.3 - 0.05 * k, 3);
    const ColourTrack track = See({p});
    ASSERT_EQ(Is(track), "tracked") << k;
    EXPECT_LT((track.target->centre - At(p)).norm(), 1.5) << k;
    EXPECT_NEAR(track.target->diameter_px, 2 * 250 * std::tan(std::asin(0.25 / p.norm())), 4) << k;
    EXPECT_GT(track.target->confidence, 0.8);
    if (k == 0) continue;
    EXPECT_LT(tracker_.window().area(), 320 * 240 / 2) << "not only a window around it";
  }
}

TEST_F(ColourTrackerTest, ATargetNeverSeenIsSearchedFor) {
  for (int k = 0; k < 3; ++k) {
    const ColourTrack track = See({});
    EXPECT_EQ(Is(track), "searching");
    EXPECT_FALSE(track.target);
  }
}

TEST_F(ColourTrackerTest, TwoAlikeAreAmbiguousAndNeitherIsTheTarget) {
  const ColourTrack track = See({{-0.7, 0, 3}, {0.7, 0, 3}});
  EXPECT_EQ(Is(track), "ambiguous");
  EXPECT_FALSE(track.target);
  EXPECT_EQ(Is(See({{-0.7, 0, 3}, {1.4, 0, 9}})), "tracked") << "one far smaller is no rival";
}

TEST_F(ColourTrackerTest, ASecondOneBesideTheTrackedTargetMakesItAmbiguousButDoesNotTakeItsPlace) {
  const Eigen::Vector3d own(-0.2, 0, 3);
  ASSERT_EQ(Is(See({own})), "tracked");
  ASSERT_EQ(Is(See({own})), "tracked");
  const ColourTrack track = See({own, {0.45, 0, 3}});
  EXPECT_EQ(Is(track), "ambiguous");
  ASSERT_TRUE(track.target);
  EXPECT_LT((track.target->centre - At(own)).norm(), 2);
}

TEST_F(ColourTrackerTest, CutByTheEdgeOfTheImageItSaysSo) {
  ASSERT_EQ(Is(See({{-1.5, 0, 3}})), "tracked");
  const ColourTrack track = See({{-1.87, 0, 3}});
  EXPECT_EQ(Is(track), "at the edge");
  EXPECT_TRUE(track.target);
}

TEST_F(ColourTrackerTest, ATargetThatComesNearEndsByFillingTheImage) {
  TrackState last = TrackState::kSearching;
  for (const double z : {2.0, 1.5, 1.1, 0.8, 0.6, 0.5, 0.45}) last = See({{0.02, 0.01, z}}).state;
  EXPECT_EQ(std::string(NameOf(last)), "too close");
  EXPECT_EQ(Is(See({{0, 0, 0.3}})), "too close") << "nothing but the target in the image";
  EXPECT_EQ(Is(See({{0, 0, 1.0}})), "tracked") << "and it goes away again";
}

TEST_F(ColourTrackerTest, AColourThatIsThatOfHalfTheImageMatchesTooMuch) {
  PaintedBalls world;
  world.ground = {40, 45, 170};
  const ColourTrack track = tracker_.Track(PaintBalls(kCamera, world));
  EXPECT_EQ(Is(track), "matches too much");
  EXPECT_FALSE(track.target);
}

TEST_F(ColourTrackerTest, LostItSaysSoAtOnceAndFindsItAgainAnywhere) {
  ASSERT_EQ(Is(See({{-0.8, 0, 3}})), "tracked");
  for (int k = 0; k < 5; ++k) {
    const ColourTrack lost = See({});
    ASSERT_EQ(Is(lost), "lost");
    EXPECT_FALSE(lost.target);
  }
  EXPECT_EQ(Is(See({{1.8, 0, 14}})), "lost") << "far too small to be the same";
  const Eigen::Vector3d p(0.9, 0.4, 3);
  const ColourTrack found = See({p});
  ASSERT_EQ(Is(found), "tracked");
  EXPECT_LT((found.target->centre - At(p)).norm(), 1.5);
}

TEST_F(ColourTrackerTest, LostForLongItIsForgottenAndAnotherSizeWillDo) {
  ColourTracker tracker(ColourModel(ColourRange{}), {.forget_frames = 3});
  PaintedBalls near, none, far;
  near.balls[0].p_CT = {0, 0, 2};
  none.balls.clear();
  far.balls[0].p_CT = {0, 0, 12};
  ASSERT_EQ(Is(tracker.Track(PaintBalls(kCamera, near))), "tracked");
  const cv::Mat empty = PaintBalls(kCamera, none);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(Is(tracker.Track(empty)), "lost");
  EXPECT_EQ(Is(tracker.Track(empty)), "searching");
  EXPECT_EQ(Is(tracker.Track(PaintBalls(kCamera, far))), "tracked");
}

TEST_F(ColourTrackerTest, AWallOfItsColourIsNoTarget) {
  PaintedBalls world;
  world.balls.clear();
  world.behind = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    if (std::abs(r.x() / r.z()) < 0.2 && std::abs(r.y() / r.z()) < 0.15) return Eigen::Vector3d(30, 25, 215);
    return {};
  };
  EXPECT_EQ(Is(tracker_.Track(PaintBalls(kCamera, world))), "searching");
}

TEST_F(ColourTrackerTest, ABadImageIsNamed) {
  EXPECT_EQ(Is(tracker_.Track(cv::Mat())), "bad image");
  EXPECT_EQ(Is(tracker_.Track(cv::Mat(240, 320, CV_8UC1))), "bad image");
  EXPECT_EQ(Is(tracker_.Track(cv::Mat::zeros(1, 1, CV_8UC3))), "searching") << "of one pixel, but sound";
}

}  // namespace
}  // namespace kestrel::vision
