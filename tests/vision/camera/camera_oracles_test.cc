// SPDX-License-Identifier: Apache-2.0
// The camera models against OpenCV's and against each other where they are the same.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/ccalib/omnidir.hpp>
#include <random>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Points all around the camera up to an angle from its axis, at distances from 0.1 to 20 m.
std::vector<Vector3d> PointsWithin(double max_angle_rad, int count) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> angle(0, max_angle_rad), azimuth(-M_PI, M_PI), distance(0.1, 20);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double theta = angle(rng), phi = azimuth(rng);
    points.push_back(distance(rng) * Vector3d(std::sin(theta) * std::cos(phi),
                                              std::sin(theta) * std::sin(phi), std::cos(theta)));
  }
  return points;
}

cv::Mat ForOpenCv(const std::vector<Vector3d>& points) {
  cv::Mat all(static_cast<int>(points.size()), 1, CV_64FC3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    all.at<cv::Vec3d>(static_cast<int>(i)) = {points[i].x(), points[i].y(), points[i].z()};
  }
  return all;
}

template <class Camera>
cv::Matx33d MatrixOf(const Camera& c, double skew = 0) {
  return {c.fx, skew, c.cx, 0, c.fy, c.cy, 0, 0, 1};
}

void ExpectSamePixels(const CameraModel& camera, const std::vector<Vector3d>& points, const cv::Mat& pixels) {
  ASSERT_EQ(pixels.total(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto uv = Project(camera, points[i]);
    ASSERT_TRUE(uv) << points[i].transpose();
    const cv::Vec2d& oracle = pixels.at<cv::Vec2d>(static_cast<int>(i));
    EXPECT_LT((*uv - Vector2d(oracle[0], oracle[1])).norm(), 1e-11 * (1 + uv->norm()))
        << points[i].transpose();
  }
}

void ExpectSameCamera(const CameraModel& a, const CameraModel& b, double max_angle_rad) {
  for (const Vector3d& p_CQ : PointsWithin(max_angle_rad, 2000)) {
    const auto in_a = Project(a, p_CQ), in_b = Project(b, p_CQ);
    ASSERT_TRUE(in_a && in_b) << p_CQ.transpose();
    EXPECT_LT((*in_a - *in_b).norm(), 1e-11 * (1 + in_a->norm())) << p_CQ.transpose();
  }
  EXPECT_NEAR(MaxAngle(a), MaxAngle(b), 1e-12);
}

const cv::Vec3d kZero(0, 0, 0);

TEST(CameraOracles, BrownConradyProjectsAsOpenCvDoes) {
  for (const BrownConrady& camera :
       {BrownConrady{752, 480, 458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359,
                     1.76187114e-05, 0},
        BrownConrady{640, 480, 700, 710, 310, 250, 0.12, -0.05, -2e-3, 3e-3, 0.01},
        BrownConrady{640, 480, 500, 500, 310, 250, -0.3, 0.1, 1e-3, 1e-3, -0.02}}) {
    const auto points = PointsWithin(0.99 * std::min(camera.MaxAngle(), 1.3), 3000);
    cv::Mat pixels;
    cv::projectPoints(ForOpenCv(points), kZero, kZero, MatrixOf(camera),
                      cv::Vec<double, 5>(camera.k1, camera.k2, camera.p1, camera.p2, camera.k3), pixels);
    ExpectSamePixels(camera, points, pixels);
  }
}

TEST(CameraOracles, KannalaBrandtProjectsAsOpenCvDoesInFront) {
  for (const KannalaBrandt& camera : {KannalaBrandt{512, 512, 190.98, 190.97, 254.93, 256.90, 0.0034823894,
                                                    0.00071503, -0.0020532361, 0.00020293},
                                      KannalaBrandt{640, 480, 300, 310, 310, 250, -0.02, 0.01, -0.005, 0.001},
                                      KannalaBrandt{640, 480, 300, 310, 310, 250, 0, 0, 0, 0}}) {
    const auto points = PointsWithin(0.9999 * M_PI / 2, 3000);
    cv::Mat pixels;
    cv::fisheye::projectPoints(ForOpenCv(points), pixels, kZero, kZero, MatrixOf(camera),
                               cv::Vec4d(camera.k1, camera.k2, camera.k3, camera.k4));
    ExpectSamePixels(camera, points, pixels);
  }
}

TEST(CameraOracles, UnifiedProjectsAsOpenCvDoesAllAround) {
  Unified plain{640, 480, 220, 222, 320, 240, 0.9},
      lens{640, 480, 700, 702, 320, 240, 1.5, -0.1, 0.02, 1e-3, -2e-3};
  Unified skewed = lens;
  skewed.skew = -2.5;
  for (const Unified& camera : {plain, lens, skewed}) {
    const auto points = PointsWithin(0.99 * camera.MaxAngle(), 3000);
    EXPECT_GT(camera.MaxAngle(), 2.2);
    cv::Mat pixels;
    cv::omnidir::projectPoints(ForOpenCv(points), pixels, kZero, kZero, MatrixOf(camera, camera.skew),
                               camera.xi, cv::Vec4d(camera.k1, camera.k2, camera.p1, camera.p2));
    ExpectSamePixels(camera, points, pixels);
  }
}

TEST(CameraOracles, UnifiedWithoutXiIsThePinholeWithTheSameDistortion) {
  const Unified camera{640, 480, 500, 510, 310, 250, 0, -0.2, 0.05, 1e-3, -2e-3};
  const BrownConrady same{640, 480, 500, 510, 310, 250, -0.2, 0.05, 1e-3, -2e-3, 0};
  ExpectSameCamera(camera, same, 0.99 * same.MaxAngle());
  ExpectSameCamera(Unified{640, 480, 500, 510, 310, 250}, Pinhole{640, 480, 500, 510, 310, 250}, 1.5);
}

// A parabolic mirror of focal length q under an orthographic camera: the sphere of directions seen
// stereographically, 2 q tan(theta / 2) from the axis.
TEST(CameraOracles, UnifiedWithXiOneIsTheParacatadioptricCamera) {
  const Unified camera{640, 480, 150, 150, 320, 240, 1};
  EXPECT_DOUBLE_EQ(camera.MaxAngle(), M_PI);
  for (int degrees = 1; degrees < 180; ++degrees) {
    const double theta = degrees * M_PI / 180;
    const auto uv = camera.Project({std::sin(theta), 0, std::cos(theta)});
    ASSERT_TRUE(uv);
    // On the paraboloid z = (q^2 - rho^2) / (2 q) about its focus, with 2 q = 1: the point in that direction.
    const double q = 0.5, rho = q * std::sin(theta) / (1 + std::cos(theta)) * 2;
    EXPECT_NEAR(rho / std::tan(theta), (q * q - rho * rho / 4) / q, 1e-9 * (1 + rho * rho));
    EXPECT_NEAR(uv->x() - 320, 150 * rho, 1e-10 * (1 + uv->x()));
  }
}

TEST(CameraOracles, DoubleSphereWithoutXiIsTheUnifiedModel) {
  for (const double alpha : {0.0, 0.3, 0.5, 0.62, 0.8}) {
    const DoubleSphere camera{640, 480, 180, 182, 318, 243, 0, alpha};
    // alpha = xi / (1 + xi), f = gamma / (1 + xi).
    const Unified same{640, 480, 180 / (1 - alpha), 182 / (1 - alpha), 318, 243, alpha / (1 - alpha)};
    EXPECT_NEAR(alpha, same.xi / (1 + same.xi), 1e-15);
    EXPECT_NEAR(camera.fx, same.fx / (1 + same.xi), 1e-12);
    ExpectSameCamera(camera, same, 0.99 * same.MaxAngle());
  }
}

TEST(CameraOracles, DoubleSphereWithoutAlphaIsTheUnifiedModelToo) {
  for (const double xi : {0.1, 0.6, 1.0}) {
    ExpectSameCamera(DoubleSphere{640, 480, 180, 182, 318, 243, xi, 0},
                     Unified{640, 480, 180, 182, 318, 243, xi}, 0.99 * std::acos(-xi));
  }
}

TEST(CameraOracles, KannalaBrandtIsEquidistantWithoutCoefficients) {
  const KannalaBrandt camera{640, 480, 200, 200, 320, 240};
  for (int degrees = 1; degrees < 180; ++degrees) {
    const double theta = degrees * M_PI / 180;
    EXPECT_NEAR(camera.Project({0, std::sin(theta), std::cos(theta)})->y(), 240 + 200 * theta, 1e-11);
  }
}

}  // namespace
}  // namespace kestrel::vision
