// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/pinhole.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Pinhole kCamera{640, 480, 810, 790, 300, 250};

TEST(Pinhole, ProjectsAsOpenCvDoes) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> aside(-8, 8), ahead(0.1, 20);
  std::vector<cv::Point3d> points;
  for (int i = 0; i < 200; ++i) points.emplace_back(aside(rng), aside(rng), ahead(rng));
  std::vector<cv::Point2d> pixels;
  const cv::Matx33d K(810, 0, 300, 0, 790, 250, 0, 0, 1);
  cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, cv::noArray(), pixels);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto uv = kCamera.Project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(uv);
    EXPECT_LT((*uv - Vector2d(pixels[i].x, pixels[i].y)).norm(), 1e-9 * (1 + uv->norm()));
  }
}

TEST(Pinhole, ProjectingARayReturnsItsPixel) {
  for (double u = -20; u < 660; u += 40) {
    for (double v = -20; v < 500; v += 40) {
      const Vector3d ray = *kCamera.Ray({u, v});
      EXPECT_NEAR(ray.norm(), 1, 1e-15);
      const auto back = kCamera.Project(3 * ray);
      ASSERT_TRUE(back) << u << ' ' << v;
      EXPECT_LT((*back - Vector2d(u, v)).norm(), 1e-10);
    }
  }
}

TEST(Pinhole, APointRightAndBelowTheAxisLiesRightAndBelowInTheImage) {
  EXPECT_LT((*kCamera.Project({1, 0.5, 10}) - Vector2d(381, 289.5)).norm(), 1e-12);
}

TEST(Pinhole, NothingBehindTheCameraHasAPixel) {
  EXPECT_FALSE(kCamera.Project({1, 2, -1}));
  EXPECT_FALSE(kCamera.Project({1, 2, 0}));
  EXPECT_FALSE(kCamera.Project({1, 2, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(Pinhole, CalibrationMatrixProjects) {
  const Vector3d p_CQ(0.3, -0.2, 2);
  EXPECT_LT(((kCamera.K() * p_CQ).hnormalized() - *kCamera.Project(p_CQ)).norm(), 1e-12);
}

}  // namespace
}  // namespace kestrel::vision
