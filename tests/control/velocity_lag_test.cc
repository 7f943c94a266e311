// SPDX-License-Identifier: Apache-2.0
#include "control/velocity_lag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <deque>
#include <random>

namespace kestrel {
namespace {

constexpr double kDt_s = 0.05;

// 30 s of commands that step about, and an autopilot that answers by a delay and then a lag of first order.
VelocityLagEstimator Flown(double delay_s, double lag_s, double noise_m_s, double size_m_s = 0.5) {
  VelocityLagEstimator estimator;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  std::deque<Eigen::Vector3d> asked(1 + static_cast<std::size_t>(std::lround(delay_s / kDt_s)),
                                    Eigen::Vector3d::Zero());
  Eigen::Vector3d flown = Eigen::Vector3d::Zero(), command = Eigen::Vector3d::Zero();
  for (int i = 0; i < 600; ++i) {
    const double t_s = i * kDt_s;
    if (i % 30 == 0) command = size_m_s * Eigen::Vector3d(noise(random), noise(random), noise(random));
    estimator.Add(t_s, command, t_s,
                  flown + noise_m_s * Eigen::Vector3d(noise(random), noise(random), noise(random)));
    asked.push_back(command), asked.pop_front();
    const double kept = lag_s > 0 ? std::exp(-kDt_s / lag_s) : 0;
    flown = kept * flown + (1 - kept) * asked.front();
  }
  return estimator;
}

TEST(VelocityLag, ADelayALagAndBothAreFoundInNoise) {
  for (const auto& [delay_s, lag_s] : {std::pair{0.0, 0.3}, {0.85, 0.0}, {0.4, 0.5}, {0.2, 1.0}}) {
    const VelocityLagEstimator estimator = Flown(delay_s, lag_s, 0.05);
    for (const auto& late : {estimator.Horizontal(), estimator.Vertical()}) {
      ASSERT_TRUE(late) << delay_s << ' ' << lag_s;
      EXPECT_NEAR(late->s, delay_s + lag_s, 0.16) << delay_s << ' ' << lag_s;
      EXPECT_LE(late->least_s, late->s);
    }
  }
}

TEST(VelocityLag, WhatDidNotMoveOrMovedByItselfTellsNothing) {
  EXPECT_FALSE(Flown(0.3, 0, 0.02, 0.02).Vertical());  // hardly asked for anything
  EXPECT_FALSE(Flown(0.3, 0, 2, 0.5).Vertical());      // gusts
  VelocityLagEstimator estimator = Flown(0.3, 0, 0.02);
  ASSERT_TRUE(estimator.Vertical());
  estimator.Add(40, std::nullopt, 40, Eigen::Vector3d::Zero());  // no velocity was asked for
  EXPECT_FALSE(estimator.Vertical());
}

// The definition: lambda exp(-s tau) / s has the gain 1 at lambda.
TEST(VelocityLag, TheMostLeavesAPhaseMarginOfThirtyDegrees) {
  for (const double lambda : {0.3, 0.82, 4.0}) {
    const double tau = MostLag(lambda);
    const std::complex<double> s(0, lambda), open = lambda * std::exp(-s * tau) / s;
    EXPECT_NEAR(std::abs(open), 1, 1e-12);
    EXPECT_NEAR(std::arg(open), -M_PI + M_PI / 6, 1e-12);
  }
  EXPECT_GT(MostLag(0), 1e9);
}

// The gains that hover flies by allow an autopilot as late as ArduCopter, those found on a prompt one did
// not.
TEST(VelocityLag, AGainOfFourAllowsAQuarterOfASecond) {
  EXPECT_LT(MostLag(4), 0.27);
  EXPECT_GT(MostLag(0.824), 0.85);
}

}  // namespace
}  // namespace kestrel
