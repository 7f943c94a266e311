// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/stitching/detail/warpers.hpp>

#include "vision/camera/pinhole.h"
#include "vision/enhance/canvas/projection.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// OpenCV's projectors work in floats: near the origin they are as exact as that.
constexpr float kF_px = 128;

template <class Projector>
void ExpectAsOpenCvs(Surface surface, double down_px) {
  Projector projector;
  projector.scale = kF_px;
  projector.setCameraParams();
  int compared = 0;
  for (double x = -1.5; x <= 1.5; x += 0.125)
    for (double y = -1; y <= 1; y += 0.125, ++compared) {
      float u = 0, v = 0, back_x = 0, back_y = 0;
      projector.mapForward(static_cast<float>(x), static_cast<float>(y), u, v);
      const auto at = OnSurface(surface, kF_px, {x, y, 1});
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->x(), u, 1e-4);
      EXPECT_NEAR(at->y(), v - down_px, 1e-4);
      projector.mapBackward(u, v, back_x, back_y);
      const auto w = FromSurface(surface, kF_px, {u, v - down_px});
      ASSERT_TRUE(w);
      EXPECT_NEAR(w->x() / w->z(), back_x, 1e-4 / kF_px * (1 + x * x + y * y) + 1e-6);
      EXPECT_NEAR(w->y() / w->z(), back_y, 1e-4 / kF_px * (1 + x * x + y * y) + 1e-6);
    }
  EXPECT_EQ(compared, 25 * 17);
}

TEST(SurfaceTest, PlaneIsAsOpenCvsProjector) {
  ExpectAsOpenCvs<cv::detail::PlaneProjector>(Surface::kPlane, 0);
}
TEST(SurfaceTest, CylinderIsAsOpenCvsProjector) {
  ExpectAsOpenCvs<cv::detail::CylindricalProjector>(Surface::kCylinder, 0);
}
TEST(SurfaceTest, SphereIsAsOpenCvsProjector) {
  ExpectAsOpenCvs<cv::detail::SphericalProjector>(Surface::kSphere, kF_px * std::numbers::pi / 2);
}

TEST(SurfaceTest, DirectionsComeBackFromAllAround) {
  int compared = 0;
  for (const Surface surface : {Surface::kCylinder, Surface::kSphere})
    for (double azimuth = -3.1; azimuth < 3.1; azimuth += 0.31)
      for (double elevation = -1.3; elevation < 1.3; elevation += 0.21, ++compared) {
        const Vector3d w(std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
                         std::cos(azimuth) * std::cos(elevation));
        const auto uv = OnSurface(surface, 500, 7 * w);
        ASSERT_TRUE(uv);
        EXPECT_NEAR(uv->x(), 500 * azimuth, 1e-9);
        const auto back = FromSurface(surface, 500, *uv);
        ASSERT_TRUE(back);
        EXPECT_LT((back->normalized() - w).norm(), 1e-12);
      }
  EXPECT_GT(compared, 400);
}

TEST(SurfaceTest, APlaneIsNotMetBehindIt) {
  EXPECT_FALSE(OnSurface(Surface::kPlane, 500, {0, 0, -1}));
  EXPECT_FALSE(OnSurface(Surface::kPlane, 500, {1, 0, 0}));
  EXPECT_FALSE(FromSurface(Surface::kSphere, 100, {0, 160}));
  EXPECT_FALSE(FromSurface(Surface::kCylinder, 100, {320, 0}));
}

TEST(ProjectionTest, CircumferenceIsAWholeNumberOfTiles) {
  const Pinhole camera{640, 480, 800, 800, 319.5, 239.5};
  const Projection projection(camera, Surface::kSphere, 800);
  EXPECT_EQ(projection.period_px() % 64, 0);
  EXPECT_NEAR(projection.f_px() * 2 * std::numbers::pi, projection.period_px(), 1e-9);
  EXPECT_NEAR(projection.f_px(), 800, 32 / (2 * std::numbers::pi));
}

TEST(ProjectionTest, ThePartOfAnImageHoldsAllOfIt) {
  const Pinhole camera{640, 480, 400, 400, 319.5, 239.5};
  for (const Surface surface : {Surface::kPlane, Surface::kCylinder, Surface::kSphere}) {
    const Projection projection(camera, surface, 400);
    Eigen::Matrix3d R;
    R = Eigen::AngleAxisd(surface == Surface::kPlane ? 0.2 : 2.9, Vector3d::UnitY()) *
        Eigen::AngleAxisd(0.3, Vector3d::UnitX());
    const cv::Rect part = projection.PartOf(R);
    for (int y = 0; y < 480; y += 7)
      for (int x = 0; x < 640; x += 9) {
        auto at = projection.ToSurface(R, Vector2d(x, y));
        ASSERT_TRUE(at);
        if (const int period = projection.period_px())
          at->x() -= period * std::round((at->x() - part.x - part.width / 2.0) / period);
        EXPECT_TRUE(part.contains({cvRound(at->x()), cvRound(at->y())})) << *at;
        const auto back = projection.ToImage(R.transpose(), *at);
        ASSERT_TRUE(back);
        EXPECT_LT((*back - Vector2d(x, y)).norm(), 1e-8);
      }
  }
}

}  // namespace
}  // namespace kestrel::vision
