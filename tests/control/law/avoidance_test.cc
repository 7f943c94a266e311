// SPDX-License-Identifier: Apache-2.0
#include "control/law/avoidance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector2d;

Vector2d Along(double angle) { return {std::cos(angle), std::sin(angle)}; }

// Flies it: straight on for turn_s, then the velocity goes over evenly to the one of the new heading, in the
// time that the slower of turn and velocity needs, then straight on.
double ObtainedMiss(const std::vector<Intruder>& intruders, const Vector2d& v, double heading,
                    const AvoidanceOptions& o) {
  constexpr double dt = 0.01;
  const Vector2d after = v.norm() * Along(heading);
  const double turn = std::abs(WrapAngle(heading - std::atan2(v.y(), v.x())));
  const double over_s =
      std::max(turn / Radians(o.hold.yaw_rate_limit_deg_s), (after - v).norm() / o.acceleration_m_s2);
  Vector2d own = Vector2d::Zero();
  double miss = 1e9;
  for (double t = 0; t < 120; t += dt) {
    for (const Intruder& i : intruders) miss = std::min(miss, (i.p + t * i.v - own).norm());
    const double share = std::clamp((t + dt / 2 - o.turn_s) / std::max(over_s, 1e-9), 0.0, 1.0);
    own += dt * ((1 - share) * v + share * after);
  }
  return miss;
}

// Of a path in six straight pieces from the curve, 6 m/s * 6 s / (8 * 6^2) at the most here, and of the step.
constexpr double kTolerance_m = 0.15;

double HeadingOf(const Manoeuvre& plan, const std::vector<Intruder>& intruders) {
  const Vector2d& p = intruders[plan.intruder].p;
  return std::atan2(p.y(), p.x()) - plan.bearing;
}

TEST(ApproachOf, IsTheLeastDistanceOverAllTimeToCome) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-10, 10), speed(1, 5), angle(-M_PI, M_PI);
  constexpr double dt = 0.005;
  int closing = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector2d p(place(random), place(random)), v = speed(random) * Along(angle(random));
    double least = 1e9, when = 0;
    for (double t = 0; t < 15; t += dt)
      if (const double d = (p + t * v).norm(); d < least) least = d, when = t;
    const ClosestApproach approach = ApproachOf(p, v);
    EXPECT_NEAR(approach.distance_m, least, v.norm() * dt);
    EXPECT_NEAR(approach.after_s, when, dt);
    closing += approach.after_s > 0;
  }
  EXPECT_GT(closing, 50);
  EXPECT_LT(closing, 150);
}

TEST(ApproachOf, ThoseThatPartOrKeepTheirDistanceAreNearestNow) {
  for (const Vector2d& v : {Vector2d(1, 2), Vector2d(0, 0), Vector2d(-4, 3)}) {
    const ClosestApproach approach = ApproachOf({3, 4}, v);
    EXPECT_EQ(approach.after_s, 0);
    EXPECT_EQ(approach.distance_m, 5);
  }
}

TEST(Threatened, ByWhatComesNearerThanTheDistanceWithinTheHorizonIfWeFlySo) {
  AvoidanceOptions o;
  o.horizon_s = 6;
  const Vector2d north(4, 0);
  const auto by = [&](const Vector2d& p, const Vector2d& v, const Vector2d& own) {
    const std::vector<Intruder> one{{p, v}};
    return Threatened(one, own, 2, o);
  };
  EXPECT_FALSE(Threatened({}, north, 2, o));
  EXPECT_TRUE(by({35, 0}, {-2, 0}, north));   // in 5.8 s
  EXPECT_FALSE(by({37, 0}, {-2, 0}, north));  // in 6.2 s
  EXPECT_TRUE(by({20, 1.9}, {-2, 0}, north));
  EXPECT_FALSE(by({20, 2.1}, {-2, 0}, north));
  EXPECT_TRUE(by({12, -9}, {0, 3}, north));            // crosses where we will be
  EXPECT_FALSE(by({12, -9}, {0, 3}, Vector2d(0, 4)));  // not if we fly east
  EXPECT_FALSE(by({-1, 0}, {0, 0}, north));            // near, but we leave it behind
  EXPECT_FALSE(by({1, 0}, north, north));              // near, and stays as near
  const std::vector<Intruder> two{{{50, 50}, {0, 0}}, {{20, 0}, {0, 0}}};
  EXPECT_TRUE(Threatened(two, north, 2, o));
}

TEST(PlanManoeuvre, ThereIsNoneWithoutIntruders) { EXPECT_FALSE(PlanManoeuvre({}, {4, 0}, 0, {}, {})); }

TEST(PlanManoeuvre, WithBothSidesClearItPassesByTheSignOfTheBearing) {
  for (const double yaw : {0.0, 2.8, -1.3}) {
    for (const double azimuth_deg : {2.0, -2.0}) {
      const std::vector<Intruder> far{{40 * Along(yaw + Radians(azimuth_deg)), {0, 0}}};
      const auto plan = PlanManoeuvre(far, 2 * Along(yaw), yaw, {}, {});
      ASSERT_TRUE(plan);
      EXPECT_EQ(plan->side, azimuth_deg > 0 ? PassingSide::kLeft : PassingSide::kRight);
      EXPECT_NEAR(Degrees(plan->bearing), azimuth_deg > 0 ? 50 : -50, 1e-9);
    }
  }
}

TEST(PlanManoeuvre, AChosenSideIsKept) {
  const std::vector<Intruder> right{{40 * Along(Radians(2)), {0, 0}}};
  const auto plan = PlanManoeuvre(right, {2, 0}, 0, PassingSide::kRight, {});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->side, PassingSide::kRight);
  EXPECT_NEAR(Degrees(plan->bearing), -50, 1e-9);
}

// One that would pass within half a metre of where we are in 1 to 5 s, were we to fly on; from any side.
std::vector<Intruder> AnyEncounter(std::mt19937& random, const Vector2d& v) {
  std::uniform_real_distribution<double> range(3, 20), angle(-M_PI, M_PI), when(1, 5), off(0, 0.1);
  const Vector2d p = range(random) * Along(angle(random));
  return {{p, v - p / when(random) + off(random) * Along(angle(random))}};
}

TEST(PlanManoeuvre, ThePlannedMissIsObtainedWhoeverComes) {
  std::mt19937 random(2);
  for (int k = 0; k < 100; ++k) {
    const Vector2d v(3, 0);
    std::vector<Intruder> two = AnyEncounter(random, v);
    two.push_back(AnyEncounter(random, v).front());
    AvoidanceOptions o;
    o.acceleration_m_s2 = k % 2 ? 4 : 1, o.turn_s = k % 3 * 0.5;
    const auto plan = PlanManoeuvre(two, v, 0, {}, o);
    ASSERT_TRUE(plan);
    EXPECT_NEAR(ObtainedMiss(two, v, HeadingOf(*plan, two), o), plan->miss_m, kTolerance_m) << k;
  }
}

TEST(PlanManoeuvre, TheBearingIsTheLeastThatClears) {
  std::mt19937 random(3);
  int more_than_least = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector2d v(3, 0);
    const auto one = AnyEncounter(random, v);
    const AvoidanceOptions o;
    const auto plan = PlanManoeuvre(one, v, 0, PassingSide::kLeft, o);
    ASSERT_TRUE(plan);
    if (plan->miss_m < o.clear_share * o.safe_m) continue;
    const double los = std::atan2(one[0].p.y(), one[0].p.x());
    for (double deg = o.hold.bearing_deg; deg < Degrees(plan->bearing) - 1; deg += 5, ++more_than_least)
      EXPECT_LT(ObtainedMiss(one, v, los - Radians(deg), o), o.clear_share * o.safe_m + kTolerance_m)
          << k << ' ' << deg;
  }
  EXPECT_GT(more_than_least, 20);
}

TEST(PlanManoeuvre, IfNothingClearsItIsTheOneThatKeepsThemFarthestOff) {
  std::mt19937 random(4);
  int hopeless = 0;
  for (int k = 0; k < 40; ++k) {
    const Vector2d v(3, 0);
    const auto one = AnyEncounter(random, v);
    AvoidanceOptions o;
    o.safe_m = 4;
    const auto plan = PlanManoeuvre(one, v, 0, {}, o);
    ASSERT_TRUE(plan);
    const double los = std::atan2(one[0].p.y(), one[0].p.x());
    double best = 0;
    for (double deg = o.hold.bearing_deg; deg <= o.max_bearing_deg; deg += 5)
      for (const double sign : {-1, 1})
        best = std::max(best, ObtainedMiss(one, v, los - sign * Radians(deg), o));
    if (best > o.clear_share * o.safe_m - kTolerance_m) continue;
    ++hopeless;
    EXPECT_GT(ObtainedMiss(one, v, los - plan->bearing, o), best - kTolerance_m) << k;
  }
  EXPECT_GT(hopeless, 8);
}

TEST(PlanManoeuvre, AnotherOneOnTheSideThatWouldBeChosenTurnsItToTheOther) {
  const Intruder ahead{40 * Along(Radians(2)), {0, 0}};  // alone: passed to its left
  const Vector2d v(3, 0);
  ASSERT_EQ(PlanManoeuvre(std::vector<Intruder>{ahead}, v, 0, {}, {})->side, PassingSide::kLeft);
  // What stands where the way to the left would lead.
  const AvoidanceOptions o;
  const double heading = Radians(2) - Radians(o.hold.bearing_deg);
  const std::vector<Intruder> two{ahead, {Vector2d(3, 0) + 12 * Along(heading), {0, 0}}};
  const auto plan = PlanManoeuvre(two, v, 0, {}, o);
  EXPECT_EQ(plan->intruder, 0u);
  EXPECT_EQ(plan->side, PassingSide::kRight);
  EXPECT_GE(ObtainedMiss(two, v, HeadingOf(*plan, two), o), o.clear_share * o.safe_m - kTolerance_m);
}

TEST(PlanManoeuvre, ItHoldsTheOneThatComesNearestWithinTheHorizon) {
  AvoidanceOptions o;
  o.horizon_s = 6;
  const Vector2d v(3, 0);
  const Intruder soon{{15, 1}, {0, 0}}, nearer{{12, 0.5}, {0, 0}}, behind{{-1, 0}, {0, 0}},
      right_on_but_late{{60, 0}, {0, 0}};
  const auto held = [&](const std::vector<Intruder>& all) {
    return PlanManoeuvre(all, v, 0, {}, o)->intruder;
  };
  EXPECT_EQ(held({soon, nearer}), 1u);
  EXPECT_EQ(held({nearer, soon}), 0u);
  EXPECT_EQ(held({behind, soon}), 1u);
  EXPECT_EQ(held({right_on_but_late, soon}), 1u);
}

}  // namespace
}  // namespace kestrel::control
