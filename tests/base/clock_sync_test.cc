// SPDX-License-Identifier: Apache-2.0
#include "base/clock_sync.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kestrel {
namespace {

TEST(ClockSync, HasNothingToSayBeforeTheFirstMessage) { EXPECT_FALSE(ClockSync().ToOurs(1)); }

TEST(ClockSync, IsLateByTheShortestDelayHoweverLateTheOthers) {
  std::mt19937 random(1);
  std::exponential_distribution<double> late(1 / 0.030);
  ClockSync sync;
  const double delay_s = 0.002, offset_s = 1234.5;
  for (int i = 0; i < 500; ++i) {
    const double their_s = 0.02 * i;
    sync.AddSample(their_s, their_s + offset_s + delay_s + (i == 100 ? 0 : late(random)));
  }
  EXPECT_NEAR(*sync.ToOurs(10), 10 + offset_s + delay_s, 1e-9);
}

TEST(ClockSync, FollowsAClockThatRunsFast) {
  ClockSync sync;
  for (int i = 0; i < 30000; ++i) sync.AddSample(0.02 * i * (1 + 50e-6), 0.02 * i);  // a common crystal
  EXPECT_NEAR(*sync.ToOurs(600 * (1 + 50e-6)), 600, 50e-6 * ClockSync::kWindow_s + 1e-6);
  EXPECT_GT(std::abs(600 * 50e-6), 2 * 50e-6 * ClockSync::kWindow_s);  // what the window is for
}

TEST(ClockSync, BeginsAnewWhenTheirClockIsSetAnew) {
  ClockSync sync;
  sync.AddSample(1000, 5);
  sync.AddSample(0, 6);  // switched off and on
  EXPECT_NEAR(*sync.ToOurs(0.5), 6.5, 1e-12);
}

TEST(ClockSync, HearsNoTimeThatIsNoNumber) {
  ClockSync sync;
  sync.AddSample(std::nan(""), 5);
  EXPECT_FALSE(sync.ToOurs(1));
}

}  // namespace
}  // namespace kestrel
