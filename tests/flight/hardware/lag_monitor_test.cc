// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/lag_monitor.h"

#include <gmock/gmock.h>

#include <cmath>
#include <deque>

namespace kestrel::flight {
namespace {

// What is told in a flight of 60 s at 20 Hz whose vertical velocities are followed so late.
std::vector<std::string> Told(double delay_s, double max_s, bool landed = false) {
  LagMonitor watch({.vertical_s = max_s});
  std::vector<std::string> told;
  std::deque<double> asked(1 + static_cast<std::size_t>(std::lround(delay_s / 0.05)), 0);
  for (int i = 0; i < 1200; ++i) {
    const double t_s = 0.05 * i, v_m_s = std::sin(0.9 * t_s) + (i / 50 % 2 ? 0.4 : -0.4);
    control::VehicleState state;
    state.t_s = t_s, state.landed = landed;
    state.v_N.z() = asked.front();
    const std::string text = watch.Note(t_s, control::VelocitySetpoint{{0, 0, v_m_s}, 0}, state);
    if (!text.empty()) told.push_back(text);
    asked.push_back(v_m_s), asked.pop_front();
  }
  EXPECT_EQ(watch.told().empty(), told.empty());
  return told;
}

TEST(LagWatch, AnAutopilotSlowerThanTheGainsAllowIsToldOfOnce) {
  EXPECT_THAT(Told(0.85, 0.26),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("follows vertical velocities 0."),
                                                  testing::HasSubstr("the gains allow 0.26 s"))));
}

// Of a descent that begins 4 s into the flight, from 5 m at 0.6 m/s: before it has gone three.
TEST(LagWatch, ItIsToldBeforeALandingIsDown) {
  LagMonitor watch({.vertical_s = 0.5});
  std::deque<double> asked(1 + std::lround(0.9 / 0.05), 0);
  double told_s = 0;
  for (int i = 0; i < 400; ++i) {
    const double t_s = 0.05 * i;
    control::VehicleState state;
    state.t_s = t_s, state.landed = false;
    state.v_N.z() = asked.front();
    const double v_m_s = t_s < 4 ? 0 : 0.6;
    if (!watch.Note(t_s, control::VelocitySetpoint{{0, 0, v_m_s}, 0}, state).empty() && told_s == 0)
      told_s = t_s;
    asked.push_back(v_m_s), asked.pop_front();
  }
  EXPECT_GT(told_s, 4);
  EXPECT_LT(told_s, 9);
}

TEST(LagWatch, OneThatIsAsPromptAsTheyNeedIsNot) {
  EXPECT_THAT(Told(0.85, 1.27), testing::IsEmpty());
  EXPECT_THAT(Told(0.1, 0.26), testing::IsEmpty());
  EXPECT_THAT(Told(0.85, 0.26, true), testing::IsEmpty());  // on the ground nothing is followed
}

}  // namespace
}  // namespace kestrel::flight
