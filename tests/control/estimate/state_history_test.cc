// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/state_history.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/pose.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

// Flies on a curve and turns about a fixed axis.
VehicleState Truth(double t) {
  VehicleState state;
  state.t_s = t;
  state.p_NB = {std::sin(t), 2 * t, -std::cos(2 * t)};
  state.v_N = {std::cos(t), 2, 2 * std::sin(2 * t)};
  state.w_B = {0.3, -0.5, 0.4};
  state.R_NB = ExpRotation({0.1, 0.2, 0.3}) * ExpRotation(t * state.w_B);
  return state;
}

StateHistory Flown(double from, double to, double dt) {
  StateHistory history;
  for (int i = 0; from + i * dt <= to + 1e-9; ++i) history.Add(Truth(from + i * dt));
  return history;
}

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return LogRotation(a.conjugate() * b).norm();
}

TEST(StateHistory, KnowsNothingBeforeItHears) { EXPECT_FALSE(StateHistory().At(0)); }

TEST(StateHistory, GivesBackWhatItHeardAtItsTime) {
  const StateHistory history = Flown(1, 2, 0.1);
  for (int i = 0; i <= 10; ++i) {
    const VehicleState heard = Truth(1 + i * 0.1);
    const auto state = history.At(heard.t_s);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->t_s, heard.t_s);
    EXPECT_LT((state->p_NB - heard.p_NB).norm(), 1e-12);
    EXPECT_LT((state->v_N - heard.v_N).norm(), 1e-12);
    EXPECT_LT(AngleBetween(state->R_NB, heard.R_NB), 1e-7);
  }
}

TEST(StateHistory, LiesOnTheCurveBetweenTwoStates) {
  const StateHistory history = Flown(0, 1.5, 0.05);
  for (double t = 0.003; t < 1.5; t += 0.011) {
    const auto state = history.At(t);
    ASSERT_TRUE(state);
    EXPECT_NEAR(state->t_s, t, 1e-12);
    EXPECT_LT((state->p_NB - Truth(t).p_NB).norm(), 2e-3) << t;
    EXPECT_LT((state->v_N - Truth(t).v_N).norm(), 3e-3) << t;
    EXPECT_LT(AngleBetween(state->R_NB, Truth(t).R_NB), 1e-7) << t;  // the turn is steady
  }
}

TEST(StateHistory, IsSmoothAcrossTheStates) {
  const StateHistory history = Flown(0, 1, 0.1);
  const double h = 1e-5;
  for (int i = 1; i < 10; ++i) {
    const double t = 0.1 * i;
    const Vector3d before = (history.At(t)->p_NB - history.At(t - h)->p_NB) / h;
    const Vector3d after = (history.At(t + h)->p_NB - history.At(t)->p_NB) / h;
    EXPECT_LT((before - Truth(t).v_N).norm(), 1e-3) << i;
    EXPECT_LT((after - Truth(t).v_N).norm(), 1e-3) << i;
  }
}

TEST(StateHistory, ReachesALittleOutsideByItsVelocities) {
  const StateHistory history = Flown(1, 2, 0.1);
  for (const double t : {0.95, 2.05}) {
    const auto state = history.At(t, 0.06);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->t_s, t);
    const VehicleState end = Truth(t < 1 ? 1 : 2);
    EXPECT_LT((state->p_NB - (end.p_NB + (t - end.t_s) * end.v_N)).norm(), 1e-9);
    EXPECT_LT(AngleBetween(state->R_NB, Truth(t).R_NB), 1e-7);
  }
  EXPECT_FALSE(history.At(0.93, 0.06));
  EXPECT_FALSE(history.At(2.07, 0.06));
}

TEST(StateHistory, ForgetsWhatIsOlderThanItsLength) {
  StateHistory history(0.5);
  for (int i = 0; i <= 20; ++i) history.Add(Truth(0.1 * i));
  EXPECT_TRUE(history.At(1.55, 0));
  EXPECT_FALSE(history.At(1.4, 0));
}

TEST(StateHistory, TakesTheLastStateOfATimeAndNoneThatGoesBack) {
  StateHistory history = Flown(0, 1, 0.1);
  VehicleState again = Truth(1);
  again.p_NB = {7, 8, 9};
  again.t_s = history.At(1, 0.1)->t_s;
  history.Add(Truth(1));
  history.Add(again);
  EXPECT_LT((history.At(1)->p_NB - again.p_NB).norm(), 1e-9);
  VehicleState late = Truth(0.55);
  late.p_NB = {-1, -1, -1};
  history.Add(late);
  EXPECT_LT((history.At(0.55)->p_NB - Truth(0.55).p_NB).norm(), 1e-2);
  EXPECT_LT((history.At(1)->p_NB - again.p_NB).norm(), 1e-9);
}

}  // namespace
}  // namespace kestrel::control
