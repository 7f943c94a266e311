// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/avoid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scenarios/avoid/avoid_report.h"
#include "tests/scenarios/ball_pictures.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

constexpr double kSpeed_m_s = 2;

// The mission in an aircraft that does at once what it is told.
class Flyer {
 public:
  static AvoidFlight Flight() {
    AvoidFlight flight;
    flight.speed_m_s = kSpeed_m_s;
    flight.course_m = 20;
    flight.marks.front().diameter_m = 1;
    return flight;
  }
  explicit Flyer(const AvoidFlight& flight = Flight(), double course = 0)
      : yaw(course), mission_(MakeMission(flight, BallPictures::Parts())) {}

  // What is seen, and then it flies on by what is decided.
  mission::Decision See(const cv::Mat& image, double frame_s = BallPictures::kFrame_s) {
    const mission::Decision d = mission_->Step({image, t_s, static_cast<std::int64_t>(20 * t_s)}, State());
    EXPECT_TRUE(d.setpoint);
    const control::VelocitySetpoint c = std::get<control::VelocitySetpoint>(*d.setpoint);
    EXPECT_TRUE(c.v_H.allFinite() && std::isfinite(c.yaw_rate));
    p_N += frame_s * (HeadingRotation(yaw) * c.v_H);
    yaw += frame_s * c.yaw_rate;
    t_s += frame_s;
    return d;
  }
  mission::Decision See(const std::vector<Ball>& balls, int frames = 1) {
    mission::Decision d;
    for (int i = 0; i < frames; ++i) d = See(pictures.Draw(balls, State()));
    return d;
  }
  control::VehicleState State() const {
    control::VehicleState state = LevelAt(t_s, p_N, yaw);
    state.v_N = HeadingRotation(yaw) * Vector3d(kSpeed_m_s, 0, 0);
    return state;
  }
  bool Accomplished() const { return mission_->Accomplished(); }

  static control::VelocitySetpoint Command(const mission::Decision& d) {
    return std::get<control::VelocitySetpoint>(*d.setpoint);
  }

  BallPictures pictures;
  Vector3d p_N{0, 0, -4};
  double yaw, t_s = 0;

 private:
  std::unique_ptr<mission::Mission> mission_;
};

Ball Mark(double ahead, double right) { return {.p_N = {ahead, right, -4}, .diameter_m = 1}; }
constexpr int kConfirmed = 12;  // frames, until a threat is believed

TEST(Avoid, WithNobodyAboutItFliesStraightOnItsCourse) {
  Flyer f(Flyer::Flight(), Radians(70));
  for (int i = 0; i < 10; ++i) {
    const mission::Decision d = f.See(std::vector<Ball>{});
    EXPECT_EQ(d.phase, "cruise");
    EXPECT_FALSE(EncounterOf(d));
    EXPECT_LT((Flyer::Command(d).v_H - Vector3d(kSpeed_m_s, 0, 0)).norm(), 1e-9);
    EXPECT_NEAR(Flyer::Command(d).yaw_rate, 0, 1e-9);
  }
}

TEST(Avoid, WhatIsRightAheadIsHeldOnTheSideWhereItIsSeen) {
  for (const double side : {1.0, -1.0}) {
    Flyer f;
    const mission::Decision d = f.See({Mark(10, 0.4 * side)}, kConfirmed);
    EXPECT_EQ(d.phase, "avoid");
    EXPECT_EQ(d.target, "tracked");
    EXPECT_LT(side * Flyer::Command(d).yaw_rate, -0.1);  // away from it
    ASSERT_TRUE(EncounterOf(d) && EncounterOf(d)->wanted);
    EXPECT_GE(side * *EncounterOf(d)->wanted, Radians(50));
    EXPECT_NEAR(*EncounterOf(d)->range_m, (Mark(10, 0.4 * side).p_N - f.p_N).head<2>().norm(), 0.4);
    EXPECT_NEAR(Flyer::Command(d).v_H.x(), kSpeed_m_s, 1e-12);
  }
}

TEST(Avoid, WhatStandsAsideOfTheCourseIsLeftThere) {
  Flyer f;
  const mission::Decision d = f.See({Mark(10, 4)}, kConfirmed);
  EXPECT_EQ(d.phase, "cruise");
  ASSERT_TRUE(EncounterOf(d));
  EXPECT_FALSE(EncounterOf(d)->wanted);
  EXPECT_NEAR(*EncounterOf(d)->miss_m, 4, 0.4);
  EXPECT_NEAR(Flyer::Command(d).yaw_rate, 0, 1e-9);
}

TEST(Avoid, WhoIsSeenOnceOrFarAboveOrBelowIsNoThreat) {
  Flyer once;
  EXPECT_FALSE(EncounterOf(once.See({Mark(10, 0.4)}, 4)));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(once.See(std::vector<Ball>{}).phase, "cruise");
  for (const double height : {4.6, -4.6}) {
    Ball ball = Mark(9.5, 0.2);
    ball.p_N.z() -= height;
    Flyer f;
    for (int i = 0; i < 16; ++i) {
      const mission::Decision d = f.See(std::vector<Ball>{ball});
      EXPECT_EQ(d.phase, "cruise") << height;
      if (i > 6 && i < 10) {
        EXPECT_NE(d.target, "lost") << height;  // it is seen
      }
    }
  }
}

TEST(Avoid, WithoutAvoidingItSeesThemAndNeverTurns) {
  AvoidFlight flight = Flyer::Flight();
  flight.avoids = false;
  Flyer f(flight);
  for (int i = 0; i < 20; ++i) {
    const mission::Decision d = f.See(std::vector<Ball>{Mark(10, 0.4)});
    EXPECT_NEAR(Flyer::Command(d).yaw_rate, 0, 1e-9);
    EXPECT_EQ(d.phase, "cruise");
    if (i < 10) continue;
    ASSERT_TRUE(EncounterOf(d));
    EXPECT_LT(*EncounterOf(d)->miss_m, 1);
  }
}

TEST(Avoid, TheYawRateKeepsToItsLimit) {
  AvoidFlight flight = Flyer::Flight();
  flight.avoidance.hold.yaw_rate_limit_deg_s = 10;
  Flyer f(flight);
  double greatest = 0;
  for (int i = 0; i < kConfirmed + 5; ++i)
    greatest = std::max(greatest, std::abs(Flyer::Command(f.See({Mark(10, 0.4)}, 1)).yaw_rate));
  EXPECT_NEAR(greatest, Radians(10), 1e-9);
  Flyer turned(flight);
  turned.See(std::vector<Ball>{});
  turned.yaw = 1.5;
  EXPECT_NEAR(Flyer::Command(turned.See(std::vector<Ball>{})).yaw_rate, -Radians(10), 1e-9);
}

TEST(Avoid, BesideItsCourseItReturnsAt45DegreesAtMost) {
  for (const double side : {1.0, -1.0}) {
    Flyer f;
    f.See(std::vector<Ball>{});
    f.p_N.y() = 5 * side;
    mission::Decision d = f.See(std::vector<Ball>{});
    EXPECT_EQ(d.phase, "return");
    EXPECT_LT(side * Flyer::Command(d).yaw_rate, -0.1);
    f.yaw = -side * Radians(45);
    d = f.See(std::vector<Ball>{});
    EXPECT_NEAR(Flyer::Command(d).yaw_rate, 0, 1e-9);
  }
}

TEST(Avoid, ItKeepsTheHeightWhereItBegan) {
  Flyer f;
  f.See(std::vector<Ball>{});
  f.p_N.z() = -4.5;
  EXPECT_NEAR(Flyer::Command(f.See(std::vector<Ball>{})).v_H.z(), 0.4, 0.01);
  f.p_N.z() = -1;
  EXPECT_NEAR(Flyer::Command(f.See(std::vector<Ball>{})).v_H.z(), -1, 1e-9);
}

TEST(Avoid, AtTheEndOfItsCourseItHasReachedItsGoalAndStops) {
  AvoidFlight flight = Flyer::Flight();
  flight.course_m = 2;
  Flyer f(flight, Radians(-120));
  mission::Decision d;
  while (d.outcome.empty() && f.t_s < 5) {
    EXPECT_FALSE(f.Accomplished());
    d = f.See(std::vector<Ball>{});
  }
  EXPECT_EQ(d.outcome, "goal reached");
  EXPECT_EQ(d.phase, "goal");
  EXPECT_TRUE(f.Accomplished());
  EXPECT_EQ(Flyer::Command(d).v_H, Vector3d::Zero());
  EXPECT_EQ(Flyer::Command(d).yaw_rate, 0);
  EXPECT_NEAR(f.p_N.head<2>().norm(), 1.5, kSpeed_m_s * BallPictures::kFrame_s + 1e-9);
}

TEST(Avoid, AFrozenImageIsNamed) {
  Flyer f;
  f.See({Mark(10, 0.4)}, 4);
  const cv::Mat last = f.pictures.Draw({Mark(10, 0.4)}, f.State());
  EXPECT_EQ(f.See(last).target, "tracked");
  EXPECT_EQ(f.See(last).target, "frozen");
}

TEST(Avoid, WhoDoesNotSeeDoesNotFlyAhead) {
  Flyer f;
  const cv::Mat frozen = f.pictures.Draw({}, f.State());
  cv::Mat all_of_it(frozen.size(), CV_8UC3);
  for (const bool is_frozen : {true, false}) {
    int blind_after = 0;
    for (int i = 0; i < 30; ++i) {
      all_of_it.setTo(cv::Scalar(i, 0, 200));  // red all over, and never twice the same
      const mission::Decision d = f.See(is_frozen ? frozen : all_of_it);
      if (d.phase != "blind") {
        EXPECT_EQ(Flyer::Command(d).v_H.x(), kSpeed_m_s);
        ASSERT_EQ(blind_after, i) << "once blind it stays so";
        ++blind_after;
        continue;
      }
      EXPECT_EQ(Flyer::Command(d).v_H, Vector3d::Zero());
      EXPECT_EQ(Flyer::Command(d).yaw_rate, 0);
      EXPECT_NE(d.target, "searching");
    }
    EXPECT_NEAR(blind_after * BallPictures::kFrame_s, 0.5, 0.11) << is_frozen;
    EXPECT_EQ(f.See(std::vector<Ball>{}).phase, "cruise");
  }
}

TEST(Avoid, WhoHasNotBeenSeenForLongerThanItRemembersIsForgotten) {
  AvoidFlight flight = Flyer::Flight();
  flight.avoids = false;
  flight.memory_s = 0.5;
  Flyer f(flight);
  EXPECT_TRUE(EncounterOf(f.See({Mark(10, 0.4)}, 8)));
  EXPECT_TRUE(EncounterOf(f.See({}, 9)));
  EXPECT_FALSE(EncounterOf(f.See({}, 3)));
}

TEST(Avoid, ABlackAWhiteAndAnImageOfOneColourTurnNothingAndStopIt) {
  for (const cv::Scalar& colour : {cv::Scalar(0, 0, 0), cv::Scalar(255, 255, 255), cv::Scalar(215, 30, 25)}) {
    Flyer f;
    for (int i = 0; i < 20; ++i) {
      const mission::Decision d = f.See(f.pictures.Noisy(BallPictures::Plain(colour)));
      EXPECT_EQ(d.target, "blank");
      EXPECT_EQ(d.phase, i < 11 ? "cruise" : "blind") << i;
      EXPECT_EQ(Flyer::Command(d).v_H.x(), i < 11 ? kSpeed_m_s : 0.0) << i;
      EXPECT_NEAR(Flyer::Command(d).yaw_rate, 0, 1e-9);
    }
  }
}

TEST(Avoid, ItPassesWhatStandsOnItsCourseAndReachesItsGoal) {
  Flyer f;
  double nearest = 1e9;
  mission::Decision d;
  while (d.outcome.empty() && f.t_s < 30) {
    d = f.See(f.pictures.Draw({Mark(10, 0.4)}, f.State()), 0.1);
    nearest = std::min(nearest, (f.p_N - Mark(10, 0.4).p_N).norm());
  }
  EXPECT_EQ(d.outcome, "goal reached");
  EXPECT_GT(nearest, 2);
  EXPECT_LT(std::abs(f.p_N.y()), 1);
}

}  // namespace
}  // namespace kestrel::scenarios
