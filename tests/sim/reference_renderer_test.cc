// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/reference_renderer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/opengl_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel {
namespace {

const Pinhole kCamera{160, 120, 110, 110, 79.5, 59.5};

class ReferenceOnScene : public ::testing::TestWithParam<TestScene> {};

TEST_P(ReferenceOnScene, AgreesWithOpenGl) {
  const ModelPtr model = CompileScene(GetParam().xml);
  ASSERT_TRUE(model);
  const DataPtr data = StateOf(model.get());
  const Pose& X_NC = GetParam().X_NC;
  const cv::Mat truth = reference::Render(model.get(), data.get(), X_NC, kCamera, 4);
  OpenGlRenderer opengl(model.get(), kCamera, {.samples = 4});
  opengl.Render(data.get(), X_NC);
  const cv::Mat drawn = opengl.Render(data.get(), X_NC);
  cv::Mat difference;
  cv::absdiff(truth, drawn, difference);
  std::string file = GetParam().name;
  for (char& c : file) if (c == ' ') c = '_';
  cv::Mat all;
  cv::hconcat(std::vector<cv::Mat>{truth, drawn, difference * 8}, all);
  cv::resize(all, all, {}, 3, 3, cv::INTER_NEAREST);
  if (const char* folder = std::getenv("KESTREL_SHOW")) cv::imwrite(std::string(folder) + "/" + file + ".png", all);
  const cv::Scalar mean = cv::mean(difference);
  printf("%-20s %.3f %.3f %.3f\n", file.c_str(), mean[0], mean[1], mean[2]);
}

INSTANTIATE_TEST_SUITE_P(All, ReferenceOnScene, ::testing::ValuesIn(TestScenes()), [](const auto& scene) {
  std::string name = scene.param.name;
  std::erase(name, ' ');
  return name;
});

}  // namespace
}  // namespace kestrel
namespace kestrel {
TEST(Tmp, Headlight) {
  const ModelPtr model = CompileScene("<mujoco><visual><headlight ambient='0 0 0' diffuse='1 1 1'/></visual><worldbody><geom type='sphere' size='0.5' pos='3 0 0' rgba='1 1 1 1'/><geom type='sphere' size='0.5' pos='-3 0 0' rgba='1 1 1 1'/></worldbody></mujoco>");
  const DataPtr data = StateOf(model.get());
  OpenGlRenderer gl(model.get(), kCamera, {.samples=4});
  for (double yaw : {0., 3.14159265, 0.}) for (int k = 0; k < 2; ++k) {
    const Pose X = LookingFrom({0,0,0}, yaw, 0);
    cv::Mat a = gl.Render(data.get(), X), b = reference::Render(model.get(), data.get(), X, kCamera, 4);
    printf("yaw %.1f render %d: gl %.2f reference %.2f\n", yaw, k, cv::mean(a)[0], cv::mean(b)[0]);
  }
}
}
