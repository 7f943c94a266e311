// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/lens_lookup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sim/render/opengl/opengl_renderer.h"
#include "tests/sim/lenses.h"
#include "tests/sim/scenes.h"
#include "tests/sim/small_worlds.h"

namespace kestrel::sim {
namespace {

// The others are drawn as they are.
std::vector<Lens> LensesOfFaces() {
  std::vector<Lens> all = Lenses();
  std::erase_if(all, [](const Lens& lens) { return OnlyFace(lens.camera).has_value(); });
  return all;
}

class LensLookupTest : public ::testing::TestWithParam<Lens> {};
INSTANTIATE_TEST_SUITE_P(Lenses, LensLookupTest, ::testing::ValuesIn(LensesOfFaces()), NameOfLens);

// A picture between its pixels. x to the right, y up, from the middle of its lower left pixel.
cv::Vec3d Between(const cv::Mat& picture, double x, double y) {
  const int left = static_cast<int>(x), low = static_cast<int>(y);
  const double right = x - left, up = y - low;
  const auto at = [&](int column, int row) {
    return cv::Vec3d(picture.at<cv::Vec3b>(picture.rows - 1 - row, column));
  };
  return (1 - up) * ((1 - right) * at(left, low) + right * at(left + 1, low)) +
         up * ((1 - right) * at(left, low + 1) + right * at(left + 1, low + 1));
}

// Against the definition, from pictures of the faces that are drawn as pinholes of their own. Places are known to
// a 256th of a pixel, which is a grey level where black meets white.
TEST_P(LensLookupTest, EachPixelIsTheMeanOverItsPatch) {
  const vision::CameraModel& camera = GetParam().camera;
  const ModelPtr model = DarkRoom(R"(<geom type="box" pos="3 1 1" size="1 1 1" rgba="0.9 0.4 0.1 1"/>
    <geom type="box" pos="-2 2 0" size="0.7 0.7 2" rgba="0.2 0.9 0.5 1"/>
    <geom type="box" pos="0 -3 1" size="1 0.5 2" rgba="0.3 0.2 1 1"/>
    <geom type="box" pos="0 0 -2" size="6 6 0.1" rgba="0.6 0.5 0.4 1"/>)");
  const DataPtr data = StateOf(model.get());
  const Pose X_NC = LookingFrom({0.5, 0.2, -1.5}, 0.3, -0.9, 0.2);
  const LensFaces lens = PlanFaces(camera, 8192);
  for (const int samples : {0, 4}) {
    std::vector<cv::Mat> pictures;
    for (const Face& face : lens.faces)
      pictures.push_back(OpenGlRenderer(model.get(), face.camera, {.samples = samples})
                             .Render(data.get(), {X_NC.R * face.R_CV, X_NC.p}));
    const cv::Mat image = OpenGlRenderer(model.get(), camera, {.samples = samples}).Render(data.get(), X_NC);
    double sum = 0, worst = 0;
    int values = 0;
    for (std::size_t i = 0; i < lens.patches.size(); ++i) {
      const Patch& p = lens.patches[i];
      if (p.face == Patch::kOutside) continue;
      cv::Vec3d mean;
      for (int v = 0; v < p.across_v; ++v)
        for (int u = 0; u < p.across_u; ++u) {
          const double along_u = (u + 0.5) / p.across_u - 0.5, along_v = (v + 0.5) / p.across_v - 0.5;
          mean += Between(pictures[p.face], (p.x + along_u * p.u_x + along_v * p.v_x) / 65536,
                          (p.y + along_u * p.u_y + along_v * p.v_y) / 65536);
        }
      mean /= p.across_u * p.across_v;
      const double off = cv::norm(mean - cv::Vec3d(image.ptr<cv::Vec3b>()[i]), cv::NORM_INF);
      sum += off, worst = std::max(worst, off), ++values;
    }
    EXPECT_LT(sum / values, 0.3);
    EXPECT_LT(worst, 1.6);
  }
}

}  // namespace
}  // namespace kestrel::sim
