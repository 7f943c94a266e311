// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/image_motion.h"

#include <gtest/gtest.h>

#include <opencv2/core/eigen.hpp>

#include "tests/vision/enhance/motion/random_scene.h"
#include "vision/landmark/features/features.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

ImageMotion Between(const cv::Mat& a, const cv::Mat& b, const ImageMotionOptions& options = {}) {
  MotionImage from(a), to(b);
  return MotionBetween(from, to, {}, options);
}

double WorstCorner_px(const Matrix3d& H, const Matrix3d& truth, const cv::Size& size) {
  double worst = 0;
  for (const Vector2d& p :
       {Vector2d(0, 0), Vector2d(size.width, 0), Vector2d(size.width, size.height), Vector2d(0, size.height)})
    worst = std::max(worst, (Transfer(H, p) - Transfer(truth, p)).norm());
  return worst;
}

TEST(ImageMotion, AKnownHomographyIsFoundByEachMethod) {
  const cv::Mat scene = RandomScene({320, 240}, 1);
  Matrix3d truth;
  truth << 1.01, 0.02, 3, -0.02, 0.99, -2, 2e-5, -1e-5, 1;
  cv::Mat H, moved;
  cv::eigen2cv(truth, H);
  cv::warpPerspective(scene, moved, H, scene.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  int methods = 0;
  for (const char* method : {"lk", "sift", "surf", "orb"}) {
    if (std::string(method) == "surf" && !IsAvailable(FeatureDetector::kSurf)) continue;
    ImageMotionOptions options;
    options.method = method;
    const ImageMotion motion = Between(scene, moved, options);
    ASSERT_EQ(motion.state, MotionState::kFollowed) << method;
    EXPECT_LT(WorstCorner_px(motion.H, truth, scene.size()), std::string(method) == "lk" ? 0.3 : 2.5)
        << method;
    ++methods;
  }
  EXPECT_EQ(methods, IsAvailable(FeatureDetector::kSurf) ? 4 : 3);
}

TEST(ImageMotion, AJumpOf300PixelsIsRecovered) {
  const cv::Mat scene = RandomScene({1000, 480}, 2);
  const ImageMotion motion = Between(scene(cv::Rect(0, 0, 640, 480)), scene(cv::Rect(300, 0, 640, 480)));
  ASSERT_EQ(motion.state, MotionState::kRecovered) << NameOf(motion.state);
  Matrix3d truth = Matrix3d::Identity();
  truth(0, 2) = -300;
  EXPECT_LT(WorstCorner_px(motion.H, truth, {640, 480}), 1);
}

TEST(ImageMotion, WhatHasNoMotionSaysWhy) {
  const cv::Mat scene = RandomScene({320, 240}, 3), other = RandomScene({320, 240}, 4),
                flat(240, 320, CV_8UC1, 90);
  EXPECT_EQ(Between(scene, other).state, MotionState::kCut);
  EXPECT_EQ(Between(scene, flat).state, MotionState::kTextureless);
  EXPECT_EQ(Between(flat, scene).state, MotionState::kTextureless);
  EXPECT_EQ(Between(scene, RandomScene({160, 120}, 3)).state, MotionState::kResized);
}

}  // namespace
}  // namespace kestrel::vision
