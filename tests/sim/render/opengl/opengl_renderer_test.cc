// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/opengl_renderer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/world/scene.h"
#include "tests/sim/scenes.h"
#include "tests/sim/small_worlds.h"

namespace kestrel::sim {
namespace {

using ::testing::HasSubstr;

const vision::Pinhole kCamera{640, 480, 810.81, 810.81, 319.5, 239.5};

Eigen::Vector2d Centroid(const cv::Mat& image, int channel) {
  cv::Mat one;
  cv::extractChannel(image, one, channel);
  const cv::Moments m = cv::moments(one);
  return {m.m10 / m.m00, m.m01 / m.m00};
}

ModelPtr Colourful() {
  return CompileScene(R"(<mujoco>
  <asset>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="0.2 0.4 0.8" rgb2="1 1 1" width="64" height="384"/>
    <texture name="ground" type="2d" builtin="checker" rgb1="0.2 0.5 0.2" rgb2="0.5 0.4 0.3" width="256" height="256"/>
    <material name="ground" texture="ground" texrepeat="1 1" texuniform="true"/>
  </asset>
  <worldbody>
    <light directional="true" dir="0.3 0.2 -1"/>
    <geom type="plane" size="200 200 1" material="ground"/>
    <geom type="box" pos="6 1 1" size="0.5 0.8 1" rgba="0.8 0.2 0.1 1"/>
    <geom type="sphere" pos="5 -1 0.5" size="0.5" rgba="0.1 0.3 0.9 1"/>
  </worldbody>
</mujoco>)");
}

std::vector<cv::Mat> FlyPast(const mjModel* model, const std::string& backend) {
  const DataPtr data = StateOf(model);
  OpenGlRenderer renderer(model, kCamera, {.backend = backend});
  std::vector<cv::Mat> images;
  for (int i = 0; i < 4; ++i)
    images.push_back(
        renderer.Render(data.get(), LookingFrom({0.2 * i, -0.3, -1.5}, 0.1 * i, -0.2, 0.05 * i)));
  return images;
}

bool Same(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (cv::norm(a[i], b[i], cv::NORM_INF) != 0) return false;
  return a.size() == b.size();
}

double Difference(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, cv::norm(a[i], b[i], cv::NORM_L1) / static_cast<double>(a[i].total() * 3));
  return worst;
}

TEST(OpenGlRenderer, DrawsEachPointWhereThePinholeModelPutsIt) {
  const std::vector<vision::Pinhole> cameras{
      kCamera, {640, 480, 700, 700, 250.3, 300.7}, {331, 257, 300, 300, 201.4, 101.8}};
  RandomStream random(7, "poses");
  for (const vision::Pinhole& camera : cameras) {
    for (int i = 0; i < 4; ++i) {
      const Pose X_NC = LookingFrom({random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-9, -1)},
                                    random.Uniform(-3, 3), random.Uniform(-1.4, 1.4), random.Uniform(-3, 3));
      // Off the middle to all sides, at several distances, apart from each other; blue, green, red.
      const std::vector<std::pair<Eigen::Vector2d, double>> places{
          {{0.17, 0.25}, 0.7}, {{0.8, 0.21}, 2.0}, {{0.62, 0.78}, 11.0}};
      const std::vector<const char*> colours{"0 0 1", "0 1 0", "1 0 0"};
      std::vector<Eigen::Vector3d> points_C;
      std::string discs;
      for (std::size_t k = 0; k < places.size(); ++k) {
        const Eigen::Vector2d uv =
            places[k].first.cwiseProduct(Eigen::Vector2d(camera.width_px, camera.height_px)) +
            Eigen::Vector2d(random.Uniform(-1, 1), random.Uniform(-1, 1));
        const Eigen::Vector3d ray = *camera.Ray(uv);
        points_C.push_back(ray / ray.z() * places[k].second);
        discs += Disc(X_NC, points_C.back(), 35 / camera.fx * places[k].second, colours[k]);
      }
      const ModelPtr model = DarkRoom(discs);
      const cv::Mat image = OpenGlRenderer(model.get(), camera, {}).Render(StateOf(model.get()).get(), X_NC);
      for (std::size_t k = 0; k < places.size(); ++k)
        EXPECT_LT((Centroid(image, static_cast<int>(k)) - *camera.Project(points_C[k])).norm(), 0.05)
            << "point " << k << ", pose " << i << ", camera of " << camera.width_px << " px";
    }
  }
}

TEST(OpenGlRenderer, ImageIsUprightWithEastOnTheRightOfNorth) {
  const Pose X_NC = LookingFrom({0, 0, -2}, 0, 0);  // level, to the north
  const ModelPtr model = DarkRoom(R"(<geom type="sphere" pos="10 0 4" size="0.5" rgba="1 0 0 1"/>
    <geom type="sphere" pos="10 -2 2" size="0.5" rgba="0 1 0 1"/>)");
  const cv::Mat image = OpenGlRenderer(model.get(), kCamera, {}).Render(StateOf(model.get()).get(), X_NC);
  EXPECT_LT(Centroid(image, 2).y(), 100);  // red: above
  EXPECT_NEAR(Centroid(image, 2).x(), kCamera.cx, 0.5);
  EXPECT_GT(Centroid(image, 1).x(), 460);  // green: east
  EXPECT_NEAR(Centroid(image, 1).y(), kCamera.cy, 0.5);
}

TEST(OpenGlRenderer, SameStateGivesTheSameBitsOnEveryThread) {
  const ModelPtr model = Colourful();
  const std::vector<cv::Mat> here = FlyPast(model.get(), "auto");
  EXPECT_FALSE(Same({here[0]}, {here[1]}));
  std::vector<int> same(2);
  std::vector<std::thread> threads;
  for (int& s : same)
    threads.emplace_back([&] {
      s = 1;
      for (int i = 0; i < 3; ++i) s &= Same(FlyPast(model.get(), "auto"), here);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(same, ::testing::Each(1));
}

// A process draws with one backend: EGL draws in another, which starts this test anew, and leaves its images
// behind.
TEST(OpenGlRenderer, BackendsAgree) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto folder = std::filesystem::temp_directory_path();
  const auto file = [&](std::size_t i) {
    return (folder / ("kestrel_egl_" + std::to_string(i) + ".png")).string();
  };
  EXPECT_EXIT(
      {
        const std::vector<cv::Mat> drawn = FlyPast(Colourful().get(), "egl");
        const std::vector<cv::Mat> again = FlyPast(Colourful().get(), "egl");
        for (std::size_t i = 0; i < drawn.size(); ++i) cv::imwrite(file(i), drawn[i]);
        exit(Same(drawn, again) ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
  const std::vector<cv::Mat> osmesa = FlyPast(Colourful().get(), "osmesa");
  std::vector<cv::Mat> egl;
  for (std::size_t i = 0; i < osmesa.size(); ++i) {
    egl.push_back(cv::imread(file(i)));
    std::filesystem::remove(file(i));
    ASSERT_EQ(egl.back().size(), osmesa[i].size());
  }
  EXPECT_LT(Difference(egl, osmesa), 0.5);
}

TEST(OpenGlRenderer, DrawsShadowsAndSmoothEdgesOnlyWhenAsked) {
  const ModelPtr model = Colourful();
  const DataPtr data = StateOf(model.get());
  const Pose X_NC = LookingFrom({0, 0, -1.5}, 0, -0.2);
  const auto image = [&](const RenderOptions& o) {
    return OpenGlRenderer(model.get(), kCamera, o).Render(data.get(), X_NC);
  };
  const cv::Mat plain = image({});
  EXPECT_LT(cv::mean(image({.shadows = true}))[0], cv::mean(plain)[0] - 0.05);
  EXPECT_GT(cv::norm(image({.samples = 4}), plain, cv::NORM_INF), 20);
}

TEST(OpenGlRenderer, DrawsNoSites) {
  const ModelPtr model = DarkRoom(R"(<site pos="2 0 0" size="0.3" rgba="1 1 1 1"/>)");
  const cv::Mat image = OpenGlRenderer(model.get(), kCamera, {})
                            .Render(StateOf(model.get()).get(), LookingFrom({0, 0, 0}, 0, 0));
  EXPECT_EQ(cv::norm(image, cv::NORM_INF), 0);
}

TEST(OpenGlRenderer, RefusesCamerasItCannotDrawAndSaysWhy) {
  const ModelPtr model = DarkRoom("");
  const auto message = [&](const vision::CameraModel& camera) -> std::string {
    try {
      OpenGlRenderer(model.get(), camera, {});
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(vision::Pinhole{64, 48, 80, 81, 31.5, 23.5}), "accepted");
  EXPECT_THAT(message(vision::Pinhole{0, 480, 800, 800, 319.5, 239.5}), HasSubstr("0 x 480"));
  EXPECT_THAT(message(vision::Pinhole{640, 480, -1, -1, 319.5, 239.5}), HasSubstr("positive focal length"));
  vision::Pinhole blind{64, 48, 80, 80, 3000, 23.5};
  blind.max_angle_rad = 0.1;
  EXPECT_THAT(message(blind), HasSubstr("shows nothing"));
}

}  // namespace
}  // namespace kestrel::sim
