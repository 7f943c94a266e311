// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/render/ray/mesh/triangles.h"
#include "sim/render/ray/ray_renderer.h"
#include "sim/world/frames.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

constexpr int kSide = 90;  // points: 15842 triangles, so many parts

ModelPtr Hills(std::uint64_t seed) {
  ModelPtr model = CompileScene(R"(<mujoco><asset>
    <hfield name="hills" nrow="90" ncol="90" size="50 50 8 1"/></asset>
    <worldbody><geom type="hfield" hfield="hills"/></worldbody></mujoco>)");
  RandomStream random(seed, "hills");
  for (int i = 0; i < kSide * kSide; ++i) model->hfield_data[i] = static_cast<float>(random.Uniform(0, 1));
  return model;
}

// MuJoCo's own rays are the oracle: they know nothing of parts, tiles or Embree.
TEST(LargeMesh, IsSeenWhereverARayMeetsIt) {
  vision::KannalaBrandt camera{.width_px = 96, .height_px = 72, .fx = 26, .fy = 26, .cx = 47.5, .cy = 35.5};
  camera.max_angle_rad = Radians(95);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ModelPtr model = Hills(seed);
    const DataPtr data = StateOf(model.get());
    RandomStream random(seed, "cameras");
    RayRenderer renderer(model.get(), camera, {});
    for (int k = 0; k < 4; ++k) {
      const Pose X_NC{Eigen::Quaterniond(RotationFromTaitBryan(
                          {random.Uniform(-3, 3), random.Uniform(-1.2, 1.2), random.Uniform(-3, 3)})),
                      {random.Uniform(-40, 40), random.Uniform(-40, 40), -random.Uniform(8.5, 20)}};
      const Surfaces seen = renderer.Trace(data.get(), X_NC);
      int met = 0, missed = 0, wrong = 0;
      for (int v = 0; v < camera.height_px; ++v) {
        for (int u = 0; u < camera.width_px; ++u) {
          const auto ray_C = camera.Ray(Eigen::Vector2d(u, v));
          if (!ray_C) continue;
          mjtNum from[3], along[3];
          VectorToMujoco(X_NC.p, from);
          VectorToMujoco(X_NC.R * *ray_C, along);
          const mjtNum distance = mj_rayHfield(model.get(), data.get(), 0, from, along);
          const double depth = seen.depth_m.at<float>(v, u);
          if (distance < 0) {
            missed += std::isfinite(depth);
          } else {
            ++met;
            wrong += !(std::abs(depth - distance) < 1e-3 * distance + 1e-3);
          }
        }
      }
      EXPECT_GT(met, 200);
      EXPECT_LE(missed + wrong, 3) << "of " << met;  // rays just on an edge
    }
  }
}

TEST(LargeMesh, PartsHoldAllOfItsTriangles) {
  const ModelPtr model = Hills(4);
  const ray::Triangles t = ray::Triangles::OfHeightField(model.get(), 0);
  ASSERT_GT(t.parts.size(), 15u);
  EXPECT_EQ(t.parts.front().next, t.parts.size());
  for (const Eigen::Vector3f& vertex : t.vertices) {
    bool held = false;
    for (std::size_t i = 0; i < t.parts.size(); ++i) {
      const bool leaf = t.parts[i].next == i + 1;
      held = held || (leaf && ((vertex - t.parts[i].centre).cwiseAbs() - t.parts[i].half).maxCoeff() <= 0);
    }
    EXPECT_TRUE(held) << vertex.transpose();
  }
}

}  // namespace
}  // namespace kestrel::sim
