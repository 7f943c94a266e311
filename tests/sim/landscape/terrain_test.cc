// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/terrain.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace kestrel::sim::landscape {
namespace {

LandscapeParameters Hilly() {
  LandscapeParameters p;
  p.hills_deg = 5;
  return p;
}

TEST(Terrain, ItsMeshIsAsHighToAMilliradianAsSeenFromTheOrigin) {
  const Terrain terrain(Hilly(), 3);
  const Mesh mesh = terrain.ToMesh();
  EXPECT_LT(mesh.faces.size(), 45'000u);  // 68,400 if none were spared
  std::mt19937 random(7);
  std::uniform_int_distribution<int> degree(0, 359), ring(15, 85);  // where the terrain has its samples
  double worst = 0, highest = 0;
  int found = 0;
  for (int i = 0; i < 3000; ++i) {
    const float azimuth = static_cast<float>(degree(random)) * std::numbers::pi_v<float> / 180;
    const float r = kInner_m * std::pow(kOuter_m / kInner_m, static_cast<float>(ring(random)) / 95);
    const Eigen::Vector2f at(r * std::cos(azimuth), -r * std::sin(azimuth));
    for (const Eigen::Vector3i& face : mesh.faces) {
      const Eigen::Vector3f &a = mesh.vertices[face[0]], &b = mesh.vertices[face[1]],
                            &c = mesh.vertices[face[2]];
      if ((a.head<2>() - at).norm() > 0.6f * r) continue;
      Eigen::Matrix2f sides;
      sides << b.head<2>() - a.head<2>(), c.head<2>() - a.head<2>();
      const Eigen::Vector2f share = sides.inverse() * (at - a.head<2>());
      if (share.minCoeff() < -1e-3f || share.sum() > 1.001f) continue;
      const float drawn = a.z() + share.x() * (b.z() - a.z()) + share.y() * (c.z() - a.z());
      const float height = terrain.Height(at.x(), -at.y());
      worst = std::max(worst, std::abs(static_cast<double>(drawn - height)) / r);
      highest = std::max(highest, static_cast<double>(height) / r);
      ++found;
      break;
    }
  }
  EXPECT_EQ(found, 3000);
  EXPECT_GT(highest, 0.03);
  EXPECT_LT(worst, 1e-3);
}

TEST(Terrain, ItsMeshHasNoGap) {
  const Mesh mesh = Terrain(Hilly(), 3).ToMesh();
  const auto place = [&](int v) {
    return std::pair(std::lround(360 * mesh.st[v].x()) % 360, mesh.st[v].y());
  };
  std::map<std::pair<std::pair<long, float>, std::pair<long, float>>, int>
      edges;  // one way more than the other
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const auto from = place(face[k]), to = place(face[(k + 1) % 3]);
      if (from < to)
        ++edges[{from, to}];
      else
        --edges[{to, from}];
    }
  }
  for (const auto& [ends, more] : edges) {
    const bool border =
        ends.first.second == ends.second.second && (ends.first.second == 0 || ends.first.second == 1);
    EXPECT_EQ(more == 0, !border) << ends.first.first << " " << ends.first.second;
  }
}

}  // namespace
}  // namespace kestrel::sim::landscape
