// SPDX-License-Identifier: Apache-2.0
#include "scenarios/follow/follow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

#include "scenarios/follow/follow_report.h"
#include "tests/scenarios/ball_pictures.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

// The mission in an aircraft that stands still in the air, whatever it is told to do.
class Follower {
 public:
  static constexpr double kFrame_s = BallPictures::kFrame_s;

  static FollowFlight Impatient() {
    FollowFlight flight;
    flight.reference = {{.diameter_px = BallPictures::kFocal_px * 0.5 / 6}};  // 6 m ahead
    flight.look_around = {.stop_s = 0.3, .turn_deg_s = 30, .give_up_s = 1};
    return flight;
  }
  explicit Follower(const FollowFlight& flight = Impatient())
      : mission_(MakeMission(flight, BallPictures::Parts())) {}

  mission::Decision See(const cv::Mat& image) {
    t_s_ += kFrame_s;
    const mission::Decision d =
        mission_->Step({image, t_s_, static_cast<std::int64_t>(t_s_ / kFrame_s)}, State());
    EXPECT_TRUE(d.setpoint);
    EXPECT_TRUE(Command(d).v_H.allFinite() && std::isfinite(Command(d).yaw_rate));
    return d;
  }
  mission::Decision See(const std::vector<Ball>& balls) { return See(pictures.Draw(balls, State())); }
  mission::Decision See(const std::vector<Ball>& balls, int frames) {
    mission::Decision d;
    for (int i = 0; i < frames; ++i) d = See(balls);
    return d;
  }

  static control::VelocitySetpoint Command(const mission::Decision& d) {
    return std::get<control::VelocitySetpoint>(*d.setpoint);
  }
  control::VehicleState State() const {
    control::VehicleState state = LevelAt(t_s_, p_N, yaw);
    state.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({yaw, pitch, 0}));
    return state;
  }
  double t_s() const { return t_s_; }

  BallPictures pictures;
  Vector3d p_N{0, 0, -4};
  double yaw = 0, pitch = 0;

 private:
  std::unique_ptr<mission::Mission> mission_;
  double t_s_ = 0;
};

constexpr int kLearnt = 10;  // frames, until it is sure of the balloon

void ExpectStill(const mission::Decision& d) {
  EXPECT_EQ(Follower::Command(d).v_H, Vector3d::Zero()) << d.phase << ' ' << d.target;
}

TEST(Follow, WhereItIsWantedItIsLeftThere) {
  Follower f;
  const mission::Decision d = f.See({Ball{}}, 20);
  EXPECT_EQ(d.phase, "follow");
  EXPECT_EQ(d.target, "tracked");
  ASSERT_TRUE(SightOf(d));
  EXPECT_LT((SightOf(d)->now.Vector() - Vector3d(0, 0, 0.5 / 6)).norm(), 0.002);
  EXPECT_LT(Follower::Command(d).v_H.norm(), 0.1);
  EXPECT_LT(std::abs(Follower::Command(d).yaw_rate), 0.02);
}

TEST(Follow, TheCommandLeadsTowardsIt) {
  const auto seen_at = [](const Vector3d& p_N) {
    return Follower::Command(Follower().See({Ball{p_N}}, kLearnt));
  };
  EXPECT_GT(seen_at({7, 0, -4}).v_H.x(), 0.2);
  EXPECT_LT(seen_at({5, 0, -4}).v_H.x(), -0.2);
  EXPECT_GT(seen_at({6, 1, -4}).yaw_rate, 0.1);
  EXPECT_LT(seen_at({6, -1, -4}).yaw_rate, -0.1);
  EXPECT_GT(seen_at({6, 0, -3}).v_H.z(), 0.2);
  EXPECT_LT(seen_at({6, 0, -5}).v_H.z(), -0.2);
  EXPECT_EQ(seen_at({6, 0, -3}).v_H.y(), 0);
}

FollowFlight AsTheThesis() {
  FollowFlight flight = Follower::Impatient();
  flight.features = {.level = false, .outline = false, .filter = false};
  flight.gains.feed_forward = false;
  flight.gains.velocity_response_s = flight.gains.yaw_response_s = 0;
  return flight;
}

TEST(Follow, WithoutAnyHelpOneImageIsEnoughAndTheCommandIsThatOfTheLaw) {
  Follower f(AsTheThesis());
  const mission::Decision d = f.See(std::vector<Ball>{Ball{{7, 0.6, -4.3}}});
  ASSERT_TRUE(SightOf(d));
  const control::SphereImage &now = SightOf(d)->now, &wanted = SightOf(d)->wanted;
  EXPECT_LT((now.s - Eigen::Vector2d(0.6 / 7, -0.3 / 7)).norm(), 2 / BallPictures::kFocal_px);
  // (5.20) and (5.21) by hand.
  const double Z = 0.5 / now.diameter, x = now.s.x(), y = now.s.y();
  const Vector3d e = FollowGains{}.lambda_per_s.cwiseProduct(now.Vector() - wanted.Vector());
  EXPECT_NEAR(Follower::Command(d).v_H.z(), Z * e.y() - Z * y / now.diameter * e.z(), 1e-9);
  EXPECT_NEAR(Follower::Command(d).v_H.x(), Z * x * e.x() - Z * (x * x + 1) / now.diameter * e.z(), 1e-9);
  EXPECT_NEAR(Follower::Command(d).yaw_rate, e.x() - x / now.diameter * e.z(), 1e-9);
}

TEST(Follow, TheTiltOfTheAircraftMovesTheImageUnlessItIsThatOfALevelCamera) {
  for (const bool level : {false, true}) {
    FollowFlight flight = AsTheThesis();
    flight.features.level = level;
    Follower f(flight);
    f.pitch = Radians(-8);
    const mission::Decision d = f.See(std::vector<Ball>{Ball{}});
    ASSERT_TRUE(SightOf(d));
    EXPECT_NEAR(SightOf(d)->now.s.y(), level ? 0 : -std::tan(Radians(8)), 0.01);
  }
}

TEST(Follow, TheReferenceIsTheNewestThatHasBegun) {
  FollowFlight flight = Follower::Impatient();
  flight.reference = {{.from_s = 0, .diameter_px = 16}, {.from_s = 0.42, .u_px = 40, .diameter_px = 16}};
  Follower f(flight);
  EXPECT_EQ(SightOf(f.See({Ball{}}, 8))->wanted.s.x(), 0);  // 0.4 s
  const mission::Decision d = f.See(std::vector<Ball>{Ball{}});
  EXPECT_NEAR(SightOf(d)->wanted.s.x(), 40 / BallPictures::kFocal_px, 1e-12);
  EXPECT_LT(Follower::Command(d).yaw_rate, -0.1);  // to have it to the right it turns left
}

TEST(Follow, NeverSeenItStopsLooksAroundAndGivesUp) {
  Follower f;
  int stood = 0, turned = 0;
  while (f.t_s() < 1) {
    const mission::Decision d = f.See(std::vector<Ball>{});
    ExpectStill(d);
    EXPECT_EQ(d.target, "searching");
    EXPECT_TRUE(d.outcome.empty());
    EXPECT_FALSE(SightOf(d));
    if (f.t_s() < 0.3) {
      EXPECT_EQ(Follower::Command(d).yaw_rate, 0);
      EXPECT_EQ(d.phase, "stop");
      ++stood;
    } else if (f.t_s() > 0.4) {
      EXPECT_NEAR(Follower::Command(d).yaw_rate, Radians(30), 1e-12);
      EXPECT_EQ(d.phase, "look around");
      ++turned;
    }
  }
  EXPECT_GT(stood, 3);
  EXPECT_GT(turned, 10);
  EXPECT_EQ(f.See({}, 3).outcome, "balloon not found");
}

TEST(Follow, LostItStopsAtOnceAndTurnsToWhereItWasLast) {
  for (const double side : {1.0, -1.0}) {
    Follower f;
    const std::vector<Ball> seen{Ball{{6, side, -5}}};
    f.See(seen, kLearnt);
    // The first frame by which the last measurement is too old.
    const int coasts =
        static_cast<int>(std::ceil(mission::BalloonObserverParameters{}.coast_s / Follower::kFrame_s));
    mission::Decision d = f.See({}, coasts);
    for (int i = 0; i < 5; ++i) {
      d = f.See(std::vector<Ball>{});
      ExpectStill(d);
      EXPECT_EQ(Follower::Command(d).yaw_rate, 0);
      EXPECT_EQ(d.target, "lost");
    }
    d = f.See({}, 5);
    ExpectStill(d);
    EXPECT_NEAR(Follower::Command(d).yaw_rate, side * Radians(30), 1e-12);
    d = f.See(seen, 2);
    EXPECT_EQ(d.phase, "follow");
    EXPECT_GT(side * Follower::Command(d).yaw_rate, 0.1);
  }
}

TEST(Follow, AFrozenImageIsNamedAndNotFlownAfter) {
  Follower f;
  f.See({Ball{{8, 1, -5}}}, kLearnt);
  const cv::Mat last = f.pictures.Draw({Ball{{8, 1, -5}}}, f.State());
  EXPECT_EQ(f.See(last).target, "tracked");
  const double frozen_s = f.t_s();
  mission::Decision d;
  while (f.t_s() < frozen_s + mission::BalloonObserverParameters{}.coast_s + Follower::kFrame_s - 1e-9) {
    d = f.See(last);
    EXPECT_EQ(d.target, "frozen");
  }
  ExpectStill(d);
  EXPECT_FALSE(SightOf(d));
}

TEST(Follow, FromABalloonThatFillsTheImageItBacksOff) {
  Follower f;
  mission::Decision d;
  for (double ahead = 3; ahead > 0.31; ahead -= 0.08) d = f.See(std::vector<Ball>{Ball{{ahead, 0, -4}}});
  d = f.See({Ball{{0.31, 0, -4}}}, 8);
  EXPECT_EQ(d.phase, "too close");
  EXPECT_LT(Follower::Command(d).v_H.x(), -0.1);
  EXPECT_EQ(Follower::Command(d).v_H.tail<2>(), Eigen::Vector2d::Zero());
  EXPECT_EQ(Follower::Command(d).yaw_rate, 0);
}

TEST(Follow, TwoAlikeBeforeAnyIsChosenAreAmbiguousAndNoneIsFollowed) {
  Follower f;
  for (int i = 0; i < 15; ++i) {
    const mission::Decision d = f.See({Ball{{6, 1, -4}}, Ball{{6, -1, -4}}});
    EXPECT_EQ(d.target, "ambiguous");
    ExpectStill(d);
    EXPECT_EQ(Follower::Command(d).yaw_rate, 0);
  }
  EXPECT_EQ(f.See({Ball{{6, 1, -4}}}, kLearnt).phase, "follow");
}

TEST(Follow, WhereHalfOfTheImageHasTheColourItStandsStill) {
  Follower f;
  cv::Mat half = BallPictures::Plain();
  half(cv::Rect(0, 0, 160, 240)).setTo(Ball{}.colour);
  for (int i = 0; i < 15; ++i) {
    const mission::Decision d = f.See(f.pictures.Noisy(half));
    EXPECT_EQ(d.target, "matches too much");
    ExpectStill(d);
  }
}

TEST(Follow, ABlackAWhiteAndAnImageOfAnotherColourMoveNothing) {
  for (const cv::Scalar& colour : {cv::Scalar(0, 0, 0), cv::Scalar(255, 255, 255), cv::Scalar(215, 30, 25)}) {
    Follower noisy, same, after;
    after.See({Ball{}}, kLearnt);
    for (int i = 0; i < 10; ++i) {
      ExpectStill(noisy.See(noisy.pictures.Noisy(BallPictures::Plain(colour))));
      ExpectStill(same.See(BallPictures::Plain(colour)));
      const mission::Decision d = after.See(after.pictures.Noisy(BallPictures::Plain(colour)));
      if (i > 6) {
        ExpectStill(d);
      }
    }
  }
  Follower none;
  ExpectStill(none.See(cv::Mat()));
}

TEST(Follow, BelowTheLeastHeightItNeverGoesDown) {
  for (const double height_m : {1.5, 0.9}) {
    Follower f;
    f.p_N.z() = -height_m;
    const double below = Follower::Command(f.See({Ball{{6, 0, 0.5 - height_m}}}, kLearnt)).v_H.z();
    EXPECT_EQ(below > 0.1, height_m > 1) << below;
    EXPECT_GE(below, 0);
    Follower up;
    up.p_N.z() = -height_m;
    EXPECT_LT(Follower::Command(up.See({Ball{{6, 0, -1 - height_m}}}, kLearnt)).v_H.z(), -0.1);
  }
}

TEST(Follow, TheCommandKeepsToItsLimits) {
  FollowFlight flight = Follower::Impatient();
  flight.gains.speed_limit_m_s = 0.4, flight.gains.climb_limit_m_s = 0.2,
  flight.gains.yaw_rate_limit_deg_s = 6;
  for (const double side : {1.0, -1.0}) {
    Follower f(flight);
    const control::VelocitySetpoint c =
        Follower::Command(f.See({Ball{{10, 2 * side, -4 + 2 * side}}}, kLearnt));
    EXPECT_NEAR(c.v_H.x(), 0.4, 1e-12);
    EXPECT_NEAR(c.v_H.z(), 0.2 * side, 1e-12);
    EXPECT_NEAR(c.yaw_rate, Radians(6) * side, 1e-12);
  }
}

// Round enough for its colour to be followed, and too long to be measured as a ball.
TEST(Follow, WhatIsTooCloseIsNotLost) {
  Follower f;
  f.See({}, 10);
  cv::Mat large = BallPictures::Plain();
  cv::ellipse(large, {160, 120}, {150, 105}, 0, 0, 360, Ball{}.colour, cv::FILLED);
  for (int i = 0; i < 15; ++i) {
    const mission::Decision d = f.See(f.pictures.Noisy(large));
    EXPECT_EQ(d.phase, "too close");
    EXPECT_LT(Follower::Command(d).v_H.x(), -0.1);
  }
  const mission::Decision d =
      f.See({}, 15);  // 2 s since it was not seen for the first time, 0.75 s since the last
  EXPECT_EQ(d.phase, "look around");
  EXPECT_TRUE(d.outcome.empty());
}

}  // namespace
}  // namespace kestrel::scenarios
