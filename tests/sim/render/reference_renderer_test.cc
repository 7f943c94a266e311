// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/render/reference_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "sim/render/opengl/opengl_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

const vision::Pinhole kCamera{160, 120, 140, 140, 79.5, 59.5};

// 255 where something is, and a pixel and its neighbours up to two pixels away show the same faces of the
// same geoms.
cv::Mat AwayFromEdges(const mjModel* model, const mjData* data, const Pose& X_NC,
                      const vision::Pinhole& camera) {
  const auto hits = reference::Hits(model, data, X_NC, camera);
  const auto same = [](const std::vector<reference::Hit>& a, const std::vector<reference::Hit>& b) {
    bool all = a.size() == b.size();
    for (std::size_t i = 0; all && i < a.size(); ++i)
      all = a[i].geom == b[i].geom && a[i].normal_M.dot(b[i].normal_M) > 0.9;
    return all;
  };
  const bool sky = std::count(model->tex_type, model->tex_type + model->ntex, mjTEXTURE_SKYBOX) > 0;
  cv::Mat inner(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar::all(255));
  for (int v = 0; v < camera.height_px; ++v)
    for (int u = 0; u < camera.width_px; ++u) {
      const auto& here = hits[v * camera.width_px + u];
      if ((here.empty() && !sky) || (u > 0 && !same(here, hits[v * camera.width_px + u - 1])) ||
          (v > 0 && !same(here, hits[(v - 1) * camera.width_px + u])))
        inner.at<uchar>(v, u) = 0;
    }
  cv::erode(inner, inner, cv::Mat::ones(5, 5, CV_8UC1));
  return inner;
}

class ReferenceOnScene : public ::testing::TestWithParam<TestScene> {};

TEST_P(ReferenceOnScene, AgreesWithOpenGlAwayFromEdges) {
  const ModelPtr model = CompileScene(GetParam().xml);
  ASSERT_TRUE(model);
  const DataPtr data = StateOf(model.get());
  const Pose& X_NC = GetParam().X_NC;
  const cv::Mat truth = reference::Render(model.get(), data.get(), X_NC, kCamera, 3);
  const cv::Mat drawn = OpenGlRenderer(model.get(), kCamera, {.samples = 4}).Render(data.get(), X_NC);
  const cv::Mat inner = AwayFromEdges(model.get(), data.get(), X_NC, kCamera);
  cv::Mat difference;
  cv::absdiff(truth, drawn, difference);
  EXPECT_GT(cv::mean(inner)[0] / 255, 0.03);
  const cv::Scalar mean = cv::mean(difference, inner);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_LT(mean[channel], 2) << "blue, green, red: " << channel;
}

INSTANTIATE_TEST_SUITE_P(All, ReferenceOnScene, ::testing::ValuesIn(TestScenes()),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace kestrel::sim
