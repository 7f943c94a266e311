// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

class PadDetectorTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    reference_ = new PadReference(MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m));
    detector_ = new PadDetector(*reference_, kPadCamera);
    photographer_ = new PadPhotographer(PadPicture());
  }
  static void TearDownTestSuite() {
    delete photographer_;
    delete detector_;
    delete reference_;
  }

  // The greatest distance, px, of the outline from where it is.
  static double Error(const Eigen::Matrix3d& H_w, const Pose& X_CT) {
    double most = 0;
    for (const Eigen::Vector2d& corner : reference_->Outline()) {
      const auto truth = kPadCamera.Project(X_CT * Eigen::Vector3d(corner.x(), corner.y(), 0));
      most = std::max(most, (Transfer(H_w, corner) - truth.value()).norm());
    }
    return most;
  }

  static void ExpectFound(const Pose& X_CT, int seed) {
    const auto H_w = detector_->Detect(photographer_->At(X_CT, seed));
    ASSERT_TRUE(H_w) << "at " << X_CT.p.z() << " m, yaw " << Degrees(YawOf(X_CT.R));
    EXPECT_LT(Error(*H_w, X_CT), 2.5) << "at " << X_CT.p.z() << " m, yaw " << Degrees(YawOf(X_CT.R));
  }

  static const PadReference* reference_;
  static const PadDetector* detector_;
  static const PadPhotographer* photographer_;
};
const PadReference* PadDetectorTest::reference_;
const PadDetector* PadDetectorTest::detector_;
const PadPhotographer* PadDetectorTest::photographer_;

TEST_F(PadDetectorTest, FindsThePadFromTwoToFifteenMetres) {
  ExpectFound(PadBelow({0.02, -0.01, 2.2}, 3), 1);  // it just fits into the image
  for (const double height : {3.0, 4.2, 6.0, 8.0, 10.0, 12.5, 15.0}) {
    ExpectFound(PadBelow({0.02 * height, -0.01 * height, height}, 25 * height), static_cast<int>(height));
  }
}

TEST_F(PadDetectorTest, FindsThePadInAnyDirection) {
  for (int yaw = -180; yaw < 180; yaw += 40) ExpectFound(PadBelow({0.1, 0.05, 4.2}, yaw), yaw + 180);
}

TEST_F(PadDetectorTest, FindsThePadFromATiltedCamera) {
  for (const double tilt : {-30.0, -15.0, 15.0, 30.0}) {
    ExpectFound(PadBelow({-0.2, 0.1, 5}, 70, tilt, 0), 1);
    ExpectFound(PadBelow({0.2, 0.2, 5}, -50, 0, tilt), 2);
    ExpectFound(PadBelow({0, 0.1, 4}, 10, tilt, tilt / 2), 3);
  }
}

TEST_F(PadDetectorTest, FindsThePadInDimAndInHarshLight) {
  const Pose X_CT = PadBelow({0.1, 0, 4.2}, 33);
  for (const auto& [gain, offset] : {std::pair{0.4, 10.0}, std::pair{0.7, 60.0}, std::pair{1.3, -20.0}}) {
    const auto H_w = detector_->Detect(photographer_->At(X_CT, 5, gain, offset));
    ASSERT_TRUE(H_w) << gain;
    EXPECT_LT(Error(*H_w, X_CT), 2.5) << gain;
  }
}

TEST_F(PadDetectorTest, FindsThePadHalfInTheShade) {
  for (const double light : {0.5, 0.35, 0.25}) {
    cv::Mat printed = PadPicture();
    printed.convertTo(printed, CV_8U, (214 - 28) / 255.0, 28);
    const PadPhotographer shaded(HalfInTheShade(printed, light));
    for (const double height : {3.0, 4.2, 6.0, 7.0}) {
      const Pose X_CT = PadBelow({0.02 * height, -0.01 * height, height}, 35 * height);
      const auto H_w = detector_->Detect(shaded.At(X_CT, 3));
      ASSERT_TRUE(H_w) << light << " at " << height;
      // Of pads of 90 to 300 px. One threshold for two lights moves edges, which the tracker then sets right.
      EXPECT_LT(Error(*H_w, X_CT), 8) << light << " at " << height;
    }
  }
}

TEST_F(PadDetectorTest, FindsNothingInARectangleHalfInTheShade) {
  const PadPhotographer blank(HalfInTheShade(cv::Mat(1190, 910, CV_8UC1, cv::Scalar(220)), 0.35));
  cv::Mat framed(1190, 910, CV_8UC1, cv::Scalar(220));
  cv::rectangle(framed, {60, 60}, {850, 1130}, cv::Scalar(10), 60);
  const PadPhotographer frame(HalfInTheShade(framed, 0.35));
  for (const double height : {3.0, 4.2, 8.0})
    for (const PadPhotographer* each : {&blank, &frame})
      EXPECT_FALSE(detector_->Detect(each->At(PadBelow({0.1, 0.1, height}, 20), 1))) << height;
}

TEST_F(PadDetectorTest, FindsNothingOnTheGroundAlone) {
  const PadPhotographer ground({});
  for (const double height : {2.0, 4.2, 8.0, 15.0}) {
    EXPECT_FALSE(detector_->Detect(ground.At(PadBelow({0.3, 0.1, height}, 20), 1))) << height;
  }
}

TEST_F(PadDetectorTest, FindsNothingInARectangleOfThePadsSize) {
  for (const int grey : {255, 0}) {
    const PadPhotographer blank(cv::Mat(1190, 910, CV_8UC1, cv::Scalar(grey)));
    for (const double height : {3.0, 4.2, 8.0}) {
      EXPECT_FALSE(detector_->Detect(blank.At(PadBelow({0.1, 0.1, height}, 20), 1))) << height << ' ' << grey;
    }
  }
}

TEST_F(PadDetectorTest, TheSameImageGivesTheSameBits) {
  const cv::Mat image = photographer_->At(PadBelow({0.1, 0.1, 5}, 130, 5, 5), 1);
  const auto first = detector_->Detect(image), again = detector_->Detect(image);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(*first, *again);
}

}  // namespace
}  // namespace kestrel::vision
