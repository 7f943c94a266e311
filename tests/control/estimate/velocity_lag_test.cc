// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/velocity_lag.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kFrame_s = 0.05;

// An aircraft that answers by a lag of first order after a delay.
class Aircraft {
 public:
  Aircraft(double lag_s, double delay_s)
      : lag_s_(lag_s), waiting_(static_cast<std::size_t>(std::lround(delay_s / kStep_s)), Vector3d::Zero()) {}
  void Fly(const Vector3d& commanded, double wind_m_s2 = 0) {
    for (double t = 0; t < kFrame_s - kStep_s / 2; t += kStep_s) {
      waiting_.push_back(commanded);
      const Vector3d now = waiting_.front();
      waiting_.pop_front();
      v += lag_s_ > 0 ? Vector3d(kStep_s / lag_s_ * (now - v)) : Vector3d(now - v);
      v.z() += wind_m_s2 * kStep_s;
      p += kStep_s * v;
    }
  }
  Vector3d v = Vector3d::Zero(), p = Vector3d::Zero();

 private:
  static constexpr double kStep_s = 0.005;
  double lag_s_;
  std::deque<Vector3d> waiting_;
};

struct Flown {
  std::optional<VelocityLagEstimator::Late> horizontal, vertical;
};

// commanded: by the time and the aircraft.
Flown Fly(Aircraft aircraft, double duration_s,
          const std::function<Vector3d(double, const Aircraft&)>& commanded, double noise_m_s = 0.03,
          double wind_m_s2 = 0) {
  VelocityLagEstimator estimator;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (double t_s = 0; t_s < duration_s; t_s += kFrame_s) {
    const Vector3d noise(normal(random), normal(random), normal(random));
    const Vector3d command = commanded(t_s, aircraft);
    estimator.Add(t_s + 0.01, command, t_s, aircraft.v + noise_m_s * noise);
    aircraft.Fly(command, wind_m_s2 * normal(random));
  }
  return {estimator.Horizontal(), estimator.Vertical()};
}

Vector3d Steps(double t_s, const Aircraft&) {
  return Vector3d(std::fmod(t_s, 8) < 4 ? 0.5 : -0.3, std::fmod(t_s, 6) < 3 ? 0.4 : 0,
                  std::fmod(t_s, 10) < 5 ? 0.6 : -0.4);
}

TEST(VelocityLag, LagsAndDelaysAreFoundByWhatWasCommandedAndFlown) {
  for (const auto& [lag_s, delay_s] :
       {std::pair(0.85, 0.0), {0.0, 0.85}, {0.3, 0.0}, {0.4, 0.45}, {1.5, 0.2}, {0.0, 0.1}}) {
    const Flown flown = Fly(Aircraft(lag_s, delay_s), 25, Steps);
    ASSERT_TRUE(flown.horizontal && flown.vertical) << lag_s << ' ' << delay_s;
    for (const VelocityLagEstimator::Late& late : {*flown.horizontal, *flown.vertical}) {
      EXPECT_NEAR(late.s, lag_s + delay_s, 0.11) << lag_s << ' ' << delay_s;
      EXPECT_LE(late.min_s, lag_s + delay_s + 1e-9) << lag_s << ' ' << delay_s;
      EXPECT_GE(late.min_s, lag_s + delay_s - 0.4) << lag_s << ' ' << delay_s;
    }
  }
}

// The loop of control/law/pbvs.h about the autopilot, with noise and gusts: what is commanded depends on what
// was flown.
TEST(VelocityLag, ALoopThatCirclesTellsWhoIsLate) {
  const auto servo = [](double, const Aircraft& a) {
    return Vector3d(0, 0, std::clamp(-4 * (a.p.z() - 1), -0.8, 0.8));
  };
  const Flown late = Fly(Aircraft(0, 0.85), 40, servo, 0.03, 1);
  ASSERT_TRUE(late.vertical);
  EXPECT_NEAR(late.vertical->s, 0.85, 0.15);
  EXPECT_GT(late.vertical->min_s, MaxLag(4));
}

TEST(VelocityLag, GustsAndNoiseDoNotMakeAnAutopilotLate) {
  int told = 0;
  for (const double wind_m_s2 : {0.0, 1.0, 3.0, 10.0})
    for (const double lambda : {0.5, 1.0, 2.0}) {
      const auto servo = [lambda](double t_s, const Aircraft& a) {
        const double goal = std::fmod(t_s, 20) < 10 ? 3 : 1;
        return Vector3d(0, 0, std::clamp(-lambda * (a.p.z() - goal), -0.8, 0.8));
      };
      const Flown flown = Fly(Aircraft(0.3, 0), 60, servo, 0.05, wind_m_s2);
      if (!flown.vertical) continue;
      ++told;
      EXPECT_LE(flown.vertical->min_s, 0.45) << wind_m_s2 << ' ' << lambda;
    }
  EXPECT_GT(told, 3);
}

TEST(VelocityLag, NothingIsSaidOfWhatHardlyMovesOrIsNotCommandedLongEnough) {
  const auto still = [](double, const Aircraft&) { return Vector3d::Zero().eval(); };
  EXPECT_FALSE(Fly(Aircraft(0.5, 0), 30, still).vertical);
  EXPECT_FALSE(Fly(Aircraft(0.5, 0), 6, Steps).vertical);
  EXPECT_TRUE(Fly(Aircraft(0.5, 0), 7, Steps).vertical);
  VelocityLagEstimator estimator;
  for (double t_s = 0; t_s < 30; t_s += kFrame_s) {
    estimator.Add(t_s, Steps(t_s, {0, 0}), t_s, Steps(t_s, {0, 0}));
    if (std::fmod(t_s + 1e-9, 4) < kFrame_s) estimator.Add(t_s, std::nullopt, t_s, {});
  }
  EXPECT_FALSE(estimator.Vertical());
}

// What MostLag derives: a delay for which the loop still settles, as it does for a lag as late, and half as
// much again for which it does not.
TEST(VelocityLag, WhatTheGainsAllowSettles) {
  const auto swings = [](double lag_s, double delay_s, double lambda) {
    Aircraft aircraft(lag_s, delay_s);
    double late_swing = 0;
    for (double t_s = 0; t_s < 60; t_s += kFrame_s) {
      aircraft.Fly({0, 0, -lambda * (aircraft.p.z() - 1)});
      if (t_s > 50) late_swing = std::max(late_swing, std::abs(aircraft.p.z() - 1));
    }
    return late_swing;
  };
  for (const double lambda : {0.8, 1.2, 2.0}) {
    EXPECT_LT(swings(0, MaxLag(lambda) - kFrame_s / 2, lambda), 0.02) << lambda;
    EXPECT_LT(swings(MaxLag(lambda), 0, lambda), 0.02) << lambda;
    EXPECT_GT(swings(0, 1.55 * MaxLag(lambda), lambda), 0.5) << lambda;
  }
  EXPECT_NEAR(MaxLag(1.2), 0.873, 0.001);
  EXPECT_EQ(MaxLag(0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace kestrel::control
