// SPDX-License-Identifier: Apache-2.0
#include "vision/photometric/photometric_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector3d;

constexpr double kDepth_m = 2;
const Pinhole kCamera{.width_px = 160, .height_px = 120, .fx = 135, .fy = 135, .cx = 79.5, .cy = 59.5};

// Grey levels of a plane by a formula, so that an image from any place is exact: no picture is warped.
double Ground(double x, double y) {
  return 120 + 50 * std::sin(9 * x + 1) * std::cos(7 * y) + 30 * std::sin(5 * x - 8 * y);
}
cv::Mat Seen(const Vector3d& p, double yaw, double gain = 1, double offset = 0) {
  cv::Mat image(kCamera.height_px, kCamera.width_px, CV_8U);
  const Eigen::Quaterniond R = HeadingRotation(yaw);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const Vector3d ray = R * Vector3d((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1);
      const Vector3d at = p + (kDepth_m - p.z()) / ray.z() * ray;
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(gain * Ground(at.x(), at.y()) + offset);
    }
  return image;
}
const cv::Mat kAll(120, 160, CV_8U, cv::Scalar(255));

PhotometricOffset Wanted(double blur_px = 1.5) {
  return {Seen(Vector3d::Zero(), 0), kAll, kCamera, kDepth_m, blur_px};
}

TEST(PhotometricOffset, IsTheWayThatTheCameraIsOff) {
  for (const auto& [p, yaw] : {std::pair{Vector3d(0.02, 0, 0), 0.0},
                               {Vector3d(0, -0.02, 0), 0.0},
                               {Vector3d(0, 0, 0.03), 0.0},
                               {Vector3d(0, 0, 0), 0.02},
                               {Vector3d(0.015, 0.01, -0.02), -0.015}}) {
    const auto fix = Wanted().Compare(Seen(p, yaw), kAll);
    ASSERT_TRUE(fix);
    EXPECT_LT((fix->p_V - p).norm(), 0.002) << p.transpose();
    EXPECT_NEAR(fix->yaw, yaw, 0.002);
    EXPECT_NEAR(fix->gain, 1, 0.01);
  }
}

// The matrix by its definition: what the image changes by for a small way is what the fix undoes.
TEST(PhotometricOffset, OfASmallWayItErrsByTheSecondOrderAlone) {
  const auto error = [](double by) {
    const Vector3d p = by * Vector3d(1, -0.5, 0.7);
    return (Wanted(0.7).Compare(Seen(p, 0), kAll)->p_V - p).norm() / by;
  };
  EXPECT_LT(error(0.01), 0.02);
  EXPECT_LT(error(0.04), 0.08);
}

TEST(PhotometricOffset, ALoopOfItComesHomeFromADecimetre) {
  Vector3d p(0.1, -0.06, 0.12);
  double yaw = 0.08;
  const PhotometricOffset wanted = Wanted(2);
  for (int k = 0; k < 60; ++k) {
    const auto fix = wanted.Compare(Seen(p, yaw), kAll);
    ASSERT_TRUE(fix) << k;
    p -= 0.2 * (HeadingRotation(yaw) * fix->p_V);
    yaw -= 0.2 * fix->yaw;
  }
  EXPECT_LT(p.norm(), 0.002);
  EXPECT_LT(std::abs(yaw), 0.002);
}

TEST(PhotometricOffset, AnotherLightIsNoOtherPlace) {
  const auto fix = Wanted().Compare(Seen({0.02, 0.01, 0}, 0, 0.7, 30), kAll);
  ASSERT_TRUE(fix);
  EXPECT_LT((fix->p_V - Vector3d(0.02, 0.01, 0)).norm(), 0.002);
  EXPECT_NEAR(fix->gain, 0.7, 0.02);
}

TEST(PhotometricOffset, WhatShowsTooLittleIsNoFix) {
  cv::Mat shown = kAll.clone();
  shown.colRange(0, 100).setTo(0);
  EXPECT_FALSE(Wanted().Compare(Seen(Vector3d::Zero(), 0), shown));
  const cv::Mat grey(120, 160, CV_8U, cv::Scalar(100));
  const PhotometricOffset blank(grey, kAll, kCamera, kDepth_m, 1);
  EXPECT_FALSE(blank.Compare(grey, kAll));
  EXPECT_THROW(PhotometricOffset(grey, cv::Mat::zeros(120, 160, CV_8U), kCamera, kDepth_m, 1),
               std::invalid_argument);
}

}  // namespace
}  // namespace kestrel::vision
