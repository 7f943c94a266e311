// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/noise.h"

#include <gtest/gtest.h>

namespace kestrel::sim::landscape {
namespace {

TEST(Noise, BetweenTwoBoundsItIsWhatItIsWithoutAndBeyondThemIsBeyond) {
  const Noise noise(5, "test");
  int within = 0, below = 0, above = 0;
  for (int i = 0; i < 20000; ++i) {
    const float x = 0.173f * static_cast<float>(i) - 900, y = 0.0371f * static_cast<float>(i * 7 % 9973) - 80;
    const int octaves = 1 + i % 7;
    const float low = 0.40f + 0.02f * static_cast<float>(i % 5),
                high = low + 0.01f * static_cast<float>(i % 9);
    const float whole = noise.Fractal(x, y, octaves), bounded = noise.Fractal(x, y, octaves, low, high);
    if (whole < low) {
      EXPECT_LT(bounded, low);
      ++below;
    } else if (whole > high) {
      EXPECT_GT(bounded, high);
      ++above;
    } else {
      EXPECT_EQ(bounded, whole);
      ++within;
    }
  }
  EXPECT_GT(within, 1000);
  EXPECT_GT(below, 1000);
  EXPECT_GT(above, 1000);
}

TEST(Noise, ItsLatticeRepeatsOnBothSidesOfZero) {
  const Noise noise(5, "test");
  for (const float x : {-3.0f, -2.75f, -0.5f, -0.0f, 0.0f, 0.25f, 7.0f}) {
    EXPECT_EQ(noise.At(x, 1.5f), noise.At(x + 256, 1.5f)) << x;
    EXPECT_EQ(noise.At(1.5f, x), noise.At(1.5f, x + 256)) << x;
  }
}

}  // namespace
}  // namespace kestrel::sim::landscape
