// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/sky_light.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <span>

#include "sim/render/ray/mesh/triangle_tree.h"
#include "sim/render/ray/ray_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

constexpr double kAmbient = 0.4, kDiffuse = 0.5;

// A grey floor under a sun from the south at 45 degrees, and what stands on it or hangs over it.
ModelPtr Yard(const std::string& things) {
  return CompileScene(R"(<mujoco>
  <visual><headlight active="0"/></visual>
  <worldbody>
    <light directional="true" pos="0 0 60" dir="1 0 -1" ambient="0.4 0.4 0.4" diffuse="0.5 0.5 0.5" specular="0 0 0"/>
    <geom type="plane" size="50 50 1" rgba="0.8 0.8 0.8 1"/>)" +
                      things + "</worldbody></mujoco>");
}

// From 20 m straight above, north up: 20 px a metre.
cv::Mat FromAbove(const mjModel* model, const std::string& light, int threads = 1, bool shadows = false) {
  RenderOptions options;
  options.light = light;
  options.threads = threads;
  options.shadows = shadows;
  const vision::Pinhole camera{320, 240, 400, 400, 159.5, 119.5};
  Eigen::Matrix3d R_NC;
  R_NC << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const DataPtr data = StateOf(model);
  return RayRenderer(model, camera, options).Render(data.get(), {Eigen::Quaterniond(R_NC), {0, 0, -20}});
}

// Mean of the pixels round a place on the floor, m.
double BrightnessAt(const cv::Mat& picture, double north, double east, int half_px = 4) {
  const cv::Point at(static_cast<int>(std::lround(159.5 + 20 * east)),
                     static_cast<int>(std::lround(119.5 - 20 * north)));
  const cv::Scalar mean =
      cv::mean(picture(cv::Rect(at.x - half_px, at.y - half_px, 2 * half_px + 1, 2 * half_px + 1)));
  return (mean[0] + mean[1] + mean[2]) / 3;
}

// A sheet of 1 m, 2 m up: the sun's rays go 1 m north for each metre down.
TEST(SkyLight, ThingCastsItsShadowWhereTheSunPutsIt) {
  const ModelPtr model = Yard(R"(<geom type="box" pos="0 0 2" size="0.5 0.5 0.05"/>)");
  const cv::Mat lamps = FromAbove(model.get(), "lamps"), sky = FromAbove(model.get(), "sky");
  const double cosine = std::sqrt(0.5);
  const double in_shadow = kAmbient / (kAmbient + kDiffuse * cosine);
  EXPECT_NEAR(BrightnessAt(sky, 2, 0) / BrightnessAt(lamps, 2, 0), in_shadow, 0.06);
  for (const Eigen::Vector2d& lit :
       {Eigen::Vector2d(-2, 0), Eigen::Vector2d(4, 0), Eigen::Vector2d(2, 2), Eigen::Vector2d(2, -2)})
    EXPECT_NEAR(BrightnessAt(sky, lit.x(), lit.y()) / BrightnessAt(lamps, lit.x(), lit.y()), 1, 0.06)
        << lit.transpose();
}

// The sun is a disc of some 0.8 degrees: 2 m below an edge its half-shadow is some 4 cm wide, 20 m below ten times that.
TEST(SkyLight, ShadowIsTheSofterTheFartherItFalls) {
  const auto width_px = [](double height_m) {
    const ModelPtr model =
        Yard(fmt::format(R"(<geom type="box" pos="{} 0 {}" size="3 8 0.2"/>)", -height_m, height_m));
    const cv::Mat sky = FromAbove(model.get(), "sky"), lamps = FromAbove(model.get(), "lamps");
    int between = 0;  // along the line north through the shadow's northern edge, 3 m from the middle
    for (int v = 30; v < 110; ++v) {
      const double share = static_cast<double>(sky.at<cv::Vec3b>(v, 100)[1]) / lamps.at<cv::Vec3b>(v, 100)[1];
      between += share > 0.62 && share < 0.86;
    }
    return between;
  };
  const int near = width_px(1), far = width_px(15);
  EXPECT_LE(near, 3);
  EXPECT_GE(far, 4 * std::max(near, 1));
}

TEST(SkyLight, LessOfTheSkyIsSeenBesideAWall) {
  const ModelPtr model =
      Yard(R"(<geom type="box" pos="2 0 2" size="0.1 5 2"/>)");  // the sun is on its other side...
  const cv::Mat lamps = FromAbove(model.get(), "lamps"), sky = FromAbove(model.get(), "sky");
  const auto share = [&](double north) {
    return BrightnessAt(sky, north, 0, 3) / BrightnessAt(lamps, north, 0, 3);
  };
  EXPECT_LT(share(1.7), 0.94) << "...and yet it is darker close by";
  EXPECT_LT(share(1.7) + 0.04, share(-2));
}

TEST(SkyLight, TransparentThingCastsAPartOfAShadow) {
  const ModelPtr model = Yard(R"(<geom type="cylinder" pos="0 0 2" size="0.5 0.01" rgba="1 1 1 0.3"/>)");
  const double share =
      BrightnessAt(FromAbove(model.get(), "sky"), 2, 0) / BrightnessAt(FromAbove(model.get(), "lamps"), 2, 0);
  EXPECT_NEAR(share, (kAmbient + 0.7 * kDiffuse * std::sqrt(0.5)) / (kAmbient + kDiffuse * std::sqrt(0.5)),
              0.06);
}

TEST(SkyLight, IsTheSameForAnyNumberOfThreads) {
  if (ray::EmbreeVersion() == "none") GTEST_SKIP() << "this build has no Embree";
  for (const TestScene& scene : TestScenes()) {
    const ModelPtr model = CompileScene(scene.xml);
    const DataPtr data = StateOf(model.get());
    const vision::Pinhole camera{200, 150, 150, 150, 99.5, 74.5};
    RenderOptions options;
    options.light = "sky";
    const cv::Mat one = RayRenderer(model.get(), camera, options).Render(data.get(), scene.X_NC).clone();
    options.threads = 3;
    const cv::Mat three = RayRenderer(model.get(), camera, options).Render(data.get(), scene.X_NC);
    EXPECT_EQ(cv::norm(one, three, cv::NORM_INF), 0) << scene;
  }
}

// What is drawn for flights is as it was, bit for bit, whether anybody draws the same world with the other light or not.
TEST(SkyLight, LampsAloneAreTheDefault) {
  EXPECT_EQ(RenderOptions().light, "lamps");
  const ModelPtr model = Yard("");
  const cv::Mat floor = FromAbove(model.get(), "lamps");
  EXPECT_EQ(floor.at<cv::Vec3b>(100, 100), floor.at<cv::Vec3b>(30, 200)) << "no grain";
}

// By a row of its own for each instant, as of a rolling shutter, pixels differ by no more than what four neighbours
// share.
TEST(SkyLight, LightsRowsOfARollingShutterToo) {
  const ModelPtr model = Yard(R"(<geom type="box" pos="0 0 2" size="0.5 0.5 0.05"/>)");
  const DataPtr data = StateOf(model.get());
  RenderOptions options;
  options.light = "sky";
  const vision::Pinhole camera{320, 240, 400, 400, 159.5, 119.5};
  Eigen::Matrix3d R_NC;
  R_NC << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  RayRenderer renderer(model.get(), camera, options);
  const SceneState state{0, data.get(), {Eigen::Quaterniond(R_NC), {0, 0, -20}}};
  const cv::Mat global = renderer.Render(std::span(&state, 1), {}).clone();
  const cv::Mat rolling = renderer.Render(std::span(&state, 1), Shutter{.line_s = 1e-5});
  EXPECT_LT(cv::norm(global, rolling, cv::NORM_L1) / (3.0 * 320 * 240), 0.3);
}

}  // namespace
}  // namespace kestrel::sim
