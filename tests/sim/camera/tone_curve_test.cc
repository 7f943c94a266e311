// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/tone_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace kestrel::sim {
namespace {

std::vector<std::uint8_t> Encoded(const ToneCurve& curve, const std::vector<float>& light) {
  std::vector<std::uint8_t> bytes(light.size());
  curve.Encode(light.data(), bytes.data(), light.size());
  return bytes;
}

// By the definition: where on the curve the light is, then the nearest of the levels there.
int Reference(double light, double gamma, int bits) {
  const int top = (1 << bits) - 1;
  const double place = std::pow(std::clamp(light / 255, 0.0, 1.0), 1 / gamma);
  return static_cast<int>(std::lround(std::floor(place * top + 0.5) * 255 / top));
}

std::vector<float> ManyLights() {
  std::vector<float> light;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> even(-5, 260), exponent(-30, 8);
  for (int i = 0; i < 20000; ++i) light.push_back(even(random));
  for (int i = 0; i < 20000; ++i) light.push_back(std::exp2(exponent(random)));
  return light;
}

TEST(ToneCurve, TakesTheNearestLevelOfTheCurve) {
  const std::vector<float> light = ManyLights();
  for (const double gamma : {1.0, 1.8, 2.2, 3.0}) {
    for (const int bits : {1, 2, 5, 7, 8}) {
      const auto bytes = Encoded(ToneCurve(gamma, bits), light);
      int different = 0;
      for (std::size_t i = 0; i < light.size(); ++i) {
        const int wanted = Reference(light[i], gamma, bits);
        if (bytes[i] == wanted) continue;
        ++different;  // only where the rounding of a float decides
        const double place = std::pow(std::max(0.f, light[i]) / 255.0, 1 / gamma) * ((1 << bits) - 1);
        ASSERT_NEAR(place - std::floor(place), 0.5, 1e-4) << light[i] << ' ' << gamma << ' ' << bits;
      }
      EXPECT_LT(different, 10) << gamma << ' ' << bits;
    }
  }
}

TEST(ToneCurve, BitsAreSoManyLevelsFromBlackToWhite) {
  std::vector<float> ramp;
  for (int i = 0; i <= 4000; ++i) ramp.push_back(static_cast<float>(255 * std::pow(i / 4000.0, 3)));
  for (const double gamma : {1.0, 2.2}) {
    for (int bits = 1; bits <= 8; ++bits) {
      const auto bytes = Encoded(ToneCurve(gamma, bits), ramp);
      const std::set<int> levels(bytes.begin(), bytes.end());
      EXPECT_EQ(levels.size(), std::size_t{1} << bits);
      EXPECT_EQ(*levels.begin(), 0);
      EXPECT_EQ(*levels.rbegin(), 255);
      EXPECT_TRUE(std::is_sorted(bytes.begin(), bytes.end()));
    }
  }
}

TEST(ToneCurve, WhatIsDecodedIsCodedBack) {
  std::vector<std::uint8_t> bytes(256);
  for (int b = 0; b < 256; ++b) bytes[b] = static_cast<std::uint8_t>(b);
  for (const double gamma : {1.0, 1.5, 2.2, 3.0}) {
    const ToneCurve curve(gamma, 8);
    std::vector<float> light(256), half(256);
    curve.Decode(bytes.data(), 1, light.data(), 256);
    curve.Decode(bytes.data(), 0.5, half.data(), 256);
    for (int b = 0; b < 256; ++b) {
      EXPECT_NEAR(light[b], 255 * std::pow(b / 255.0, gamma), 1e-4);
      EXPECT_EQ(half[b], light[b] / 2);
    }
    EXPECT_EQ(Encoded(curve, light), bytes);
  }
}

TEST(ToneCurve, WhatIsNoLightIsBlack) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const double gamma : {1.0, 2.2}) {
    for (const int bits : {3, 8}) {
      const std::vector<std::uint8_t> wanted = {0, 0, 255, 255, 0};
      EXPECT_EQ(Encoded(ToneCurve(gamma, bits), {nan, -inf, inf, 1e30f, -1e30f}), wanted);
    }
  }
}

}  // namespace
}  // namespace kestrel::sim
