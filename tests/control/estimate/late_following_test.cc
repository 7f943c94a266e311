// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/late_following.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kFrame_s = 0.05;

// An autopilot that follows velocities by a lag of first order after a dead time, in an aircraft that does as
// it says, at a place.
struct Late {
  double lag_s, delay_s;
  std::deque<Vector3d> waiting = {};
  VehicleState state = {};

  void Fly(const Vector3d& asked_N) {
    constexpr double kStep_s = 0.005;
    waiting.resize(std::max(waiting.size(), static_cast<std::size_t>(std::lround(delay_s / kStep_s))),
                   Vector3d::Zero());
    for (int i = 0; i < 10; ++i) {
      waiting.push_back(asked_N);
      state.v_N += std::min(1.0, kStep_s / lag_s) * (waiting.front() - state.v_N);
      waiting.pop_front();
      state.p_NB += kStep_s * state.v_N;
    }
    state.t_s += kFrame_s;
  }
};

struct Held {
  double late_swing_m = 0;  // the farthest from the goal in the last 15 s
  double level_s = 0, climb_s = 0;
};

// Servoes to the origin from (2, -1, 1) by v = -lambda times where it will be, with noise on what the autopilot
// says of its velocity. predicts: false, by where it is.
Held Hold(Late autopilot, double lambda_per_s, bool predicts, double duration_s = 60) {
  autopilot.state.p_NB = {2, -1, 1};
  LateFollowing following;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.03);
  Held held;
  for (double t_s = 0; t_s < duration_s; t_s += kFrame_s) {
    VehicleState said = autopilot.state;
    said.v_N += Vector3d(noise(random), noise(random), noise(random));
    following.Hear(said);
    const Vector3d there = said.p_NB + (predicts ? following.ToCome_N() : Vector3d::Zero());
    const Vector3d asked = (-lambda_per_s * there).cwiseMax(-0.8).cwiseMin(0.8);
    following.Give(asked, asked);
    autopilot.Fly(asked);
    if (t_s > duration_s - 15) held.late_swing_m = std::max(held.late_swing_m, autopilot.state.p_NB.norm());
  }
  held.level_s = following.level_s(), held.climb_s = following.climb_s();
  return held;
}

TEST(LateFollowing, ALoopThatCirclesSettlesOnceItReckonsWithTheLateness) {
  int cases = 0;
  for (const auto& [lag_s, delay_s] : {std::pair(0.2, 0.85), {0.6, 0.6}, {0.1, 1.1}, {0.3, 0.45}}) {
    const double lambda = 1.9 / (lag_s + delay_s);  // beyond pi / 2 / lateness of a dead time
    const Held blind = Hold({lag_s, delay_s}, lambda, false);
    const Held seeing = Hold({lag_s, delay_s}, lambda, true);
    if (blind.late_swing_m > 0.1) ++cases;
    EXPECT_LT(seeing.late_swing_m, 0.03) << lag_s << ' ' << delay_s;
    EXPECT_NEAR(seeing.level_s, lag_s + delay_s, 0.15);
    EXPECT_NEAR(seeing.climb_s, lag_s + delay_s, 0.15);
  }
  EXPECT_GE(cases, 3);
}

TEST(LateFollowing, WithAPromptAutopilotNothingIsToCome) {
  for (const double lambda : {0.8, 2.0}) {
    const Held held = Hold({0.25, 0}, lambda, true);
    EXPECT_EQ(held.level_s, 0);
    EXPECT_EQ(held.climb_s, 0);
    EXPECT_EQ(held.late_swing_m, Hold({0.25, 0}, lambda, false).late_swing_m);
  }
}

// The way to come is the sum of what was given within the lateness; what was given is forgotten where nothing
// is given for a frame.
TEST(LateFollowing, TheWayToComeIsThatOfWhatWasGivenAndIsNotYetFlown) {
  Late autopilot{0.01, 0.8};
  LateFollowing following;
  double t_s = 0;
  for (; t_s < 25; t_s += kFrame_s) {
    following.Hear(autopilot.state);
    const Vector3d asked(std::fmod(t_s, 6) < 3 ? 0.5 : -0.5, 0, std::fmod(t_s, 8) < 4 ? -0.4 : 0.6);
    following.Give(asked, asked + Vector3d(0.1, 0, 0));
    autopilot.Fly(asked);
  }
  following.Hear(autopilot.state);
  const double level_s = following.level_s(), climb_s = following.climb_s();
  ASSERT_NEAR(level_s, 0.8, 0.11);
  ASSERT_NEAR(climb_s, 0.8, 0.11);
  EXPECT_NEAR(following.ToCome_N().x(), level_s * 0.6, 1e-9);  // 24 s to 25 s: the first half of a period
  EXPECT_NEAR(following.ToCome_N().z(), climb_s * -0.4, 1e-9);

  autopilot.Fly(Vector3d::Zero());
  following.Hear(autopilot.state);  // on the one before nothing was given
  EXPECT_EQ(following.ToCome_N(), Vector3d::Zero());
  EXPECT_EQ(following.level_s(), level_s);
}

// A turn towards a heading by a rate that follows late, at a gain that a prompt one bears. predicts: false, by the
// heading that it has. The farthest from the goal in the last 5 s of 15, rad.
double TurnTo(double lag_s, double delay_s, double gain_per_s, bool predicts, double* late_s = nullptr) {
  Late autopilot{lag_s, delay_s};
  autopilot.state.p_NB.z() = 0.5;  // its heading, and v_N its rate of turn
  LateFollowing turning(LateFollowing::OfTurns());
  double swing = 0;
  for (double t_s = 0; t_s < 15; t_s += kFrame_s) {
    turning.Hear(autopilot.state);
    const double ahead = autopilot.state.p_NB.z() + (predicts ? turning.ToCome_N().z() : 0);
    const Vector3d rate(0, 0, std::clamp(-gain_per_s * ahead, -1.0, 1.0));
    turning.Give(rate, rate);
    autopilot.Fly(rate);
    if (t_s > 10) swing = std::max(swing, std::abs(autopilot.state.p_NB.z()));
  }
  if (late_s) *late_s = turning.climb_s();
  return swing;
}

TEST(LateFollowing, ALateTurnIsKnownWithinSecondsAndReckonedWith) {
  for (const double delay_s : {0.3, 0.45}) {
    double late_s = 0;
    EXPECT_GT(TurnTo(0.3, delay_s, 4, false), 0.2) << delay_s;
    EXPECT_LT(TurnTo(0.3, delay_s, 4, true, &late_s), 0.03) << delay_s;
    EXPECT_NEAR(late_s, 0.3 + delay_s, 0.1);
  }
  double late_s = 1;
  TurnTo(0.3, 0, 2, true, &late_s);
  EXPECT_EQ(late_s, 0);
}

}  // namespace
}  // namespace kestrel::control
