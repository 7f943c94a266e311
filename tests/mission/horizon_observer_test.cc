// SPDX-License-Identifier: Apache-2.0
#include "mission/horizon_observer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "tests/vision/horizon/skyline_photographer.h"

namespace kestrel::mission {
namespace {

TEST(HorizonWatch, TurnsInTheDarkAreCountedByTheGyros) {
  vision::Unified mirror;
  mirror.width_px = 320, mirror.height_px = 240;
  mirror.fx = mirror.fy = 67, mirror.cx = 159.5, mirror.cy = 119.5;
  mirror.xi = 0.99, mirror.max_angle_rad = Radians(120);
  vision::PaintedWorld world;
  world.cloud = 25;
  world.hills = [](double a) { return 0.012 * (1.5 + std::sin(3 * a + 1) + 0.5 * std::sin(7 * a)); };
  const vision::SkylinePhotographer photographer(mirror);
  HorizonObserver watch(mirror, {Eigen::Quaterniond(vision::LooksDown()), {0, 0, 0}}, {});
  constexpr double kFrame_s = 0.05, kRate = Radians(60);
  double t_s = 0, yaw = 0;
  const auto see = [&](double rate, bool dark) {
    t_s += kFrame_s, yaw += rate * kFrame_s;
    control::VehicleState state;
    state.t_s = t_s, state.w_B = {0, 0, rate}, state.p_NB = {0, 0, -60};
    const cv::Mat image =
        dark ? cv::Mat::zeros(240, 320, CV_8UC3)
             : photographer.Paint(world, HeadingRotation(yaw).toRotationMatrix() * vision::LooksDown(),
                                  static_cast<int>(t_s / kFrame_s));
    Decision decision;
    return watch.Observe({image, t_s, 0}, state, decision);
  };
  for (int i = 0; i < 3; ++i) see(0, false);
  for (int i = 0; i < 170; ++i) EXPECT_FALSE(see(kRate, true).attitude);  // one turn and a third
  see(0, false);
  const HorizonReport report = see(0, false);
  ASSERT_TRUE(report.attitude && report.attitude->turned);
  EXPECT_NEAR(Degrees(*report.attitude->turned), Degrees(yaw), 3);
}

}  // namespace
}  // namespace kestrel::mission
