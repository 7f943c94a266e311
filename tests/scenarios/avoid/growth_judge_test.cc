// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/growth_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector2d;

constexpr double kConfirm_s = 0.25, kFrame_s = 0.05;

GrowthJudge Judge() {
  control::AvoidanceOptions avoidance;
  avoidance.max_bearing_deg = 90;
  return {GrowthOptions{}, avoidance, kConfirm_s};
}

double& Now_s() {
  static double t_s = 0;
  return t_s;
}

// The bearing that is held of others who stay as they are, after so many frames.
std::optional<double> Held(GrowthJudge& judge, const std::vector<Sighted>& others, int frames, double yaw = 0,
                           double back = 0) {
  std::optional<GrowthJudge::Judgement> judgement;
  for (int i = 0; i < frames; ++i) judgement = judge.Judge(Now_s() += kFrame_s, others, yaw, back);
  return judgement ? judgement->hold : std::nullopt;
}

TEST(GrowthJudge, DecidesTheSameWhateverTheUnitOfLength) {
  int turned = 0;
  for (const Vector2d& p : {Vector2d(30, 0.2), {30, -12}, {12, 20}, {35, 1}})
    for (const Vector2d& v : {Vector2d(-7, 0), {-4, 2}, {-3, -5}, {2, 0}}) {
      GrowthJudge metres = Judge(), others = Judge();
      const auto by_metres = Held(metres, {{p, v}}, 12), by_other = Held(others, {{0.1 * p, 0.1 * v}}, 12);
      ASSERT_EQ(by_metres.has_value(), by_other.has_value());
      if (!by_metres) continue;
      EXPECT_NEAR(*by_metres, *by_other, 1e-12);
      ++turned;
    }
  EXPECT_GT(turned, 2);
  EXPECT_LT(turned, 16);
}

TEST(GrowthJudge, WhoComesHeadOnIsHeldToTheSideOfItsBearingOnceThatHasLasted) {
  for (const double side : {1.0, -1.0}) {
    GrowthJudge judge = Judge();
    const std::vector<Sighted> others = {{{30, side}, {-7, 0}}};
    EXPECT_FALSE(Held(judge, others, 3));
    const auto held = Held(judge, others, 4);
    ASSERT_TRUE(held);
    EXPECT_GT(side * *held, Radians(49));
  }
}

TEST(GrowthJudge, WhoDriftsIsLetDriftOn) {
  GrowthJudge judge = Judge();
  // Seen a little to the left, on its way to the right: passed on its left.
  const auto held = Held(judge, {{{30, -1}, {-7, 1.3}}}, 8);
  ASSERT_TRUE(held);
  EXPECT_GT(*held, 0);
}

TEST(GrowthJudge, WhoComesAcrossIsPassedBehind) {
  for (const double side : {1.0, -1.0}) {
    GrowthJudge judge = Judge();
    // At a bearing of 27 degrees that stays: on its way across the bow.
    const auto held = Held(judge, {{{20, 10 * side}, {-4, -2 * side}}}, 8);
    ASSERT_TRUE(held);
    EXPECT_NEAR(*held, -side * Radians(50), 1e-9);
  }
}

TEST(GrowthJudge, WhoPassesFarOffOrPartsIsNoThreat) {
  for (const Sighted& other : {Sighted{{30, 0}, {7, 0}}, {{30, 7}, {-7, 0}}, {{30, 0}, {-1, 0}}}) {
    GrowthJudge judge = Judge();
    EXPECT_FALSE(Held(judge, {other}, 20));
  }
}

TEST(GrowthJudge, EndsOnceTheyPart) {
  GrowthJudge judge = Judge();
  ASSERT_TRUE(Held(judge, {{{30, 1}, {-7, 0}}}, 8));
  EXPECT_TRUE(Held(judge, {{{10, 12}, {-3, 1}}}, 8));
  EXPECT_FALSE(Held(judge, {{{-2, 12}, {-3, 1}}}, 8));
}

// Abeam to the left and falling back, as one whom we outran: the way back to the left would cross before it.
TEST(GrowthJudge, DoesNotTurnBackAcrossTheWayOfWhoIsPassed) {
  GrowthJudge judge = Judge();
  ASSERT_TRUE(Held(judge, {{{15, -2}, {-3.5, 0.5}}}, 8));
  const double yaw = Radians(85), back = Radians(-45);
  EXPECT_TRUE(Held(judge, {{{10.3, -2.2}, {-0.2, -2}}}, 40, yaw, back));
  EXPECT_TRUE(Held(judge, {{{10, -8}, {-0.2, -2}}}, 40, yaw, back));
  // As far off the way back as a turn off it leads.
  EXPECT_FALSE(Held(judge, {{{-4, -16}, {-0.2, -2}}}, 8, yaw, back));
}

TEST(GrowthJudge, DoesNotTurnBackToWhoIsOutOfSightBeforeItIsPassed) {
  GrowthJudge judge = Judge();
  const Vector2d p(20, 1), v(-5, 0);  // four seconds ahead
  ASSERT_TRUE(Held(judge, {{p, v}}, 8));
  const Sighted unseen{{-2, 12}, {-3, 1}, false};
  EXPECT_TRUE(Held(judge, {unseen}, 40));
  EXPECT_TRUE(judge.Judge(Now_s(), {}, 0, 0));
  EXPECT_FALSE(Held(judge, {unseen}, 60));
  EXPECT_FALSE(judge.Judge(Now_s(), {}, 0, 0));
}

TEST(GrowthJudge, GoesOnWhileSomebodyNearsSlowly) {
  GrowthJudge judge = Judge();
  ASSERT_TRUE(Held(judge, {{{20, -3}, {-5, 0.6}}}, 8));
  EXPECT_TRUE(Held(judge, {{{4, -10}, {0.1, 0.6}}}, 20));  // in 16 s
}

TEST(GrowthJudge, OpensTheBearingWhileTheThreatStaysOne) {
  GrowthJudge judge = Judge();
  const auto first = Held(judge, {{{30, 0.5}, {-7, 0}}}, 8);
  ASSERT_TRUE(first);
  // As far off the bow as it is to be held, and on its way towards us still.
  const Vector2d there(std::cos(*first), std::sin(*first));
  const auto then = Held(judge, {{20 * there, -5 * there}}, 8);
  ASSERT_TRUE(then);
  EXPECT_GT(*then, *first + Radians(10));
}

}  // namespace
}  // namespace kestrel::scenarios
