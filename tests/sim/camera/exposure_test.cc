// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/exposure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kestrel::sim {
namespace {

constexpr double kPeriod_s = 0.02;

AutoExposureParameters Automatic(double target_grey, double lag_s) {
  AutoExposureParameters a;
  a.target_grey = target_grey, a.lag_s = lag_s;
  return a;
}

// The mean level of an even scene, as the setting of a control makes it.
double Level(const ExposureControl& control, double scene_grey, double gamma = 1) {
  const ExposureSetting s = control.setting();
  return 255 * std::pow(std::min(1.0, s.light * s.gain * std::pow(scene_grey / 255, gamma)), 1 / gamma);
}

TEST(ExposureControl, WithoutATargetTheSettingStays) {
  ExposureParameters exposure;
  exposure.time_s = 0.004;
  ExposureControl control(exposure, {}, 1.5, 1);
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(control.setting().time_s, 0.004);
    EXPECT_EQ(control.setting().light, 1);
    EXPECT_EQ(control.setting().gain, 1.5);
    control.Meter(3, k * kPeriod_s);
  }
}

TEST(ExposureControl, ItsLagIsATimeConstantOfTheLogarithm) {
  for (const double lag_s : {0.1, 0.25, 1.0}) {
    for (const double gamma : {1.0, 2.2}) {
      for (const double scene : {60.0, 200.0}) {  // too dark, too bright
        ExposureControl control({}, Automatic(100, lag_s), 1, gamma);
        const double first = std::log(100 / Level(control, scene, gamma));
        double first_s = 0;
        for (int k = 0; k < 200; ++k) {
          const double t = k * kPeriod_s, error = std::log(100 / Level(control, scene, gamma));
          EXPECT_NEAR(error, first * std::exp(-first_s / lag_s), 1e-9) << t << ' ' << lag_s << ' ' << scene;
          control.Meter(Level(control, scene, gamma), t);
          first_s = t;  // what was metered holds from the next frame on
        }
      }
    }
  }
}

TEST(ExposureControl, CountsTheTimeBetweenFramesNotTheirNumber) {
  ExposureControl often({}, Automatic(100, 0.3), 1, 1), seldom = often;
  for (int k = 0; k <= 30; ++k) {
    often.Meter(Level(often, 40), 0.01 * k);
    if (k % 10 == 0) seldom.Meter(Level(seldom, 40), 0.01 * k);
  }
  EXPECT_NEAR(Level(often, 40), Level(seldom, 40), 1e-9);
}

TEST(ExposureControl, TakesTimeFirstAndGainBeyondIt) {
  ExposureParameters exposure;
  exposure.time_s = 0.004;
  AutoExposureParameters a = Automatic(120, 0);
  a.shortest_s = 0.001, a.longest_s = 0.01, a.highest_gain = 8;
  const auto settled = [&](double scene) {
    ExposureControl control(exposure, a, 1, 1);
    for (int k = 0; k < 50; ++k) control.Meter(Level(control, scene), k * kPeriod_s);
    return control.setting();
  };
  const ExposureSetting some = settled(60);  // twice the light
  EXPECT_NEAR(some.time_s, 0.008, 1e-6);
  EXPECT_NEAR(some.light, 2, 1e-3);
  EXPECT_NEAR(some.gain, 1, 1e-9);
  const ExposureSetting more = settled(12);  // ten times
  EXPECT_EQ(more.time_s, 0.01);
  EXPECT_EQ(more.light, 2.5);
  EXPECT_NEAR(more.gain, 4, 1e-3);
  const ExposureSetting most = settled(0);
  EXPECT_EQ(most.time_s, 0.01);
  EXPECT_EQ(most.gain, 8);
  a.target_grey = 10;
  const ExposureSetting least = settled(250);
  EXPECT_NEAR(least.time_s, 0.001, 1e-12);
  EXPECT_NEAR(least.light, 0.25, 1e-12);
  EXPECT_NEAR(least.gain, 1, 1e-12);
}

TEST(ExposureControl, WithoutATimeAnIrisTakesLightAway) {
  const auto settled = [](double scene) {
    ExposureControl control({}, Automatic(100, 0), 1, 1);
    for (int k = 0; k < 50; ++k) control.Meter(Level(control, scene), k * kPeriod_s);
    return control.setting();
  };
  EXPECT_EQ(settled(200).time_s, 0);
  EXPECT_NEAR(settled(200).light, 0.5, 1e-6);
  EXPECT_NEAR(settled(200).gain, 1, 1e-12);
  EXPECT_EQ(settled(25).light, 1);
  EXPECT_NEAR(settled(25).gain, 4, 1e-6);
}

TEST(ExposureControl, ASaturatedSceneIsFoundAsWell) {
  ExposureControl control({}, Automatic(100, 0.1), 16, 1);  // begins far too bright
  EXPECT_EQ(Level(control, 150), 255);
  for (int k = 0; k < 200; ++k) control.Meter(Level(control, 150), k * kPeriod_s);
  EXPECT_NEAR(Level(control, 150), 100, 0.1);
}

}  // namespace
}  // namespace kestrel::sim
