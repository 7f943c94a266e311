// SPDX-License-Identifier: Apache-2.0
#include "base/real_time.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(RealTime, GoesWithTheWallClockFromWhereItBegan) {
  RealTime time(1000);
  EXPECT_DOUBLE_EQ(time.Due(1000, 0), 0);
  EXPECT_NEAR(time.Due(1002.5, 2.498), 2.5, 1e-12);
  EXPECT_DOUBLE_EQ(time.WallOf(3), 1003);
  EXPECT_EQ(time.stretched_s(), 0);
  EXPECT_FALSE(time.News(1010));
}

TEST(RealTime, ALittleLateIsCaughtUp) {
  RealTime time(1000);
  EXPECT_NEAR(time.Due(1001.049, 1), 1.049, 1e-9);
  EXPECT_EQ(time.stretched_s(), 0);
}

TEST(RealTime, TooLateIsStretchedAndNothingIsSkipped) {
  RealTime time(1000);
  EXPECT_NEAR(time.Due(1001.25, 1), 1 + RealTime::kCatchUp_s, 1e-9);
  EXPECT_NEAR(time.stretched_s(), 0.2, 1e-9);
  // from then on it is on time again
  EXPECT_NEAR(time.Due(1001.26, 1.05), 1.06, 1e-9);
  EXPECT_NEAR(time.stretched_s(), 0.2, 1e-9);
  EXPECT_NEAR(time.WallOf(2), 1002.2, 1e-9);
}

TEST(RealTime, WhatIsNewIsToldOnceASecond) {
  RealTime time(1000);
  time.Due(1000.25, 0);
  EXPECT_FALSE(time.News(1000.9));
  time.Due(1000.95, 0.2);
  EXPECT_NEAR(time.News(1001.1).value(), time.stretched_s(), 1e-9);
  EXPECT_FALSE(time.News(1001.2));
  EXPECT_FALSE(time.News(1003));  // nothing new
  const double before_s = time.stretched_s();
  time.Due(1004, 2);
  EXPECT_NEAR(time.News(1004).value(), time.stretched_s() - before_s, 1e-9);
}

}  // namespace
}  // namespace kestrel
