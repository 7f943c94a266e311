// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "sim/render/ray/mesh/triangle_blocks.h"
#include "sim/render/ray/ray_renderer.h"
#include "tests/sim/render/reference_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

using ray::TriangleBlocks;

TEST(TriangleBlocks, HoldEachTriangleOnceAndTheirBoxesHoldThem) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-3, 3), step(-0.2f, 0.2f);
  for (const int count : {1, 16, 17, 700, 5000}) {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3i> faces;
    for (int f = 0; f < count; ++f) {
      const Eigen::Vector3f at(place(random), place(random), 20 * place(random));
      for (int k = 0; k < 3; ++k)
        vertices.emplace_back(at + Eigen::Vector3f(step(random), step(random), step(random)));
      faces.emplace_back(3 * f, 3 * f + 1, 3 * f + 2);
    }
    const TriangleBlocks blocks = ray::MakeBlocks(vertices, faces);
    EXPECT_EQ(blocks.blocks.size(), static_cast<std::size_t>((count + 15) / 16));
    ASSERT_EQ(blocks.levels.back().size(), 1u);
    std::vector<int> times(faces.size());
    for (int i = 0; i < count; ++i) {
      const std::size_t block = static_cast<std::size_t>(i) / 16, lane = static_cast<std::size_t>(i) % 16;
      const std::uint32_t face = blocks.blocks[block].face[lane];
      ++times[face];
      for (int k = 0; k < 3; ++k) {
        std::size_t box = block;
        const Eigen::Vector3f& corner = vertices[3 * face + static_cast<std::size_t>(k)];
        for (const auto& level : blocks.levels) {
          for (int axis = 0; axis < 3; ++axis) {
            const TriangleBlocks::Boxes& boxes = level[box / 16];
            EXPECT_LE(std::abs(corner[axis] - boxes.centre[axis][box % 16]), boxes.half[axis][box % 16]);
            EXPECT_EQ(blocks.blocks[block].corner[k][axis][lane], corner[axis]);
          }
          box /= 16;
        }
      }
    }
    EXPECT_EQ(times, std::vector<int>(faces.size(), 1)) << count;
  }
}

// A ball of so many rings of triangles, 1 m, before a sky; rough: no two corners are as far from its middle.
std::string Ball(int rings, double rough) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> bump(1 - rough, 1);
  const int around = 2 * rings;
  std::string vertices = "0 0 1 ", faces;
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double polar = M_PI * i / rings, azimuth = 2 * M_PI * j / around, r = bump(random);
      vertices += fmt::format("{} {} {} ", r * std::sin(polar) * std::cos(azimuth),
                              r * std::sin(polar) * std::sin(azimuth), r * std::cos(polar));
    }
  }
  vertices += "0 0 -1";
  const auto at = [&](int i, int j) {
    return i == 0 ? 0 : i == rings ? 1 + (rings - 1) * around : 1 + (i - 1) * around + j % around;
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      if (i > 0) faces += fmt::format("{} {} {} ", at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + 1 < rings) faces += fmt::format("{} {} {} ", at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  }
  return fmt::format(R"(<mujoco>
  <asset><mesh name="ball" vertex="{}" face="{}"/></asset>
  <worldbody><geom type="mesh" mesh="ball" contype="0" conaffinity="0"/></worldbody></mujoco>)",
                     vertices, faces);
}

// From far off, where a pixel holds many triangles, to where one is larger than the image.
TEST(Meshes, NoRaySlipsThroughBetweenTheirTriangles) {
  const ModelPtr model = CompileScene(Ball(60, 0.05));
  const DataPtr data = StateOf(model.get());
  vision::KannalaBrandt fisheye{
      .width_px = 201, .height_px = 203, .fx = 60, .fy = 60, .cx = 100.2, .cy = 101.7};
  fisheye.max_angle_rad = 1.66;
  const vision::CameraModel cameras[] = {vision::Pinhole{200, 150, 300, 300, 99.3, 75.4}, fisheye};
  int met = 0;
  for (const vision::CameraModel& camera : cameras) {
    RayRenderer renderer(model.get(), camera, {});
    for (const double away : {1.02, 1.3, 4.0, 40.0}) {
      for (const double yaw : {0.0, 1.1, 2.9}) {
        const Eigen::Vector3d eye = -away * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.2).normalized();
        const Pose X_NC = LookingFrom(eye, yaw, std::atan2(0.2, 1.0) * -1);
        const Surfaces seen = renderer.Trace(data.get(), X_NC);
        for (int v = 0; v < vision::HeightPx(camera); ++v) {
          for (int u = 0; u < vision::WidthPx(camera); ++u) {
            const auto ray = vision::Ray(camera, Eigen::Vector2d(u, v));
            if (!ray) continue;
            const Eigen::Vector3d d = X_NC.R * *ray;
            // It passes well within the ball, whose triangles are nowhere nearer to its middle than 0.94 m.
            if (-eye.dot(d) < 0 || (eye - eye.dot(d) * d).norm() > 0.93) continue;
            ++met;
            EXPECT_EQ(seen.geom.at<int>(v, u), 0) << away << " m, yaw " << yaw << ", " << u << ' ' << v;
          }
        }
      }
    }
  }
  EXPECT_GT(met, 100000);
}

// In an image of few pixels the rays of one tile part by more than a right angle from their mean.
TEST(Meshes, AreSeenAllRoundByATileThatLooksAllRound) {
  std::string geoms;
  for (const auto& [x, y, z] :
       {std::tuple{3, 0, 0}, {-3, 0, 1}, {0, 3, 0}, {0, -3, -1}, {2, 2, 2}, {2, -2, -2}})
    geoms += fmt::format(R"(<geom type="mesh" mesh="ball" pos="{} {} {}"/>)", x, y, z);
  std::string world = Ball(8, 0.05);
  const std::string one = R"(<geom type="mesh" mesh="ball" contype="0" conaffinity="0"/>)";
  world.replace(world.find(one), one.size(), geoms);
  const ModelPtr model = CompileScene(world);
  const DataPtr data = StateOf(model.get());
  for (const int size : {9, 16, 20, 40}) {
    vision::KannalaBrandt fisheye{.width_px = size, .height_px = size};
    fisheye.fx = fisheye.fy = size / 3.6;
    fisheye.cx = fisheye.cy = (size - 1) / 2.0;
    fisheye.max_angle_rad = 1.9;
    const Pose X_NC = LookingFrom({0, 0, 0}, 0.2, 0.1);
    const Surfaces seen = RayRenderer(model.get(), fisheye, {}).Trace(data.get(), X_NC);
    const reference::SurfaceErrors errors = reference::ErrorsOf(seen, model.get(), data.get(), X_NC, fisheye);
    EXPECT_LE(errors.other_geom, 1) << size;
    EXPECT_LT(errors.depth, 1e-4) << size;
  }
}

}  // namespace
}  // namespace kestrel::sim
