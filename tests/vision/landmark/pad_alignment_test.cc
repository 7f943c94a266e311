// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/landmark/pad_photographer.h"
#include "tests/vision/landmark/pose_difference.h"
#include "vision/landmark/pad_tracker.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector3d;

class PadAlignmentTest : public ::testing::Test {
 protected:
  const PadReference reference_ = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  const PadPhotographer photographer_{PadPicture()}, ground_{{}};
  PadTracker NewTracker() const { return {reference_, kPadCamera, {.method = "icia"}}; }
};

TEST_F(PadAlignmentTest, FollowsThePadWithinMillimetresAndFindsItOnce) {
  PadTracker tracker = NewTracker();
  double nees = 0;
  constexpr int kFrames = 30;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Pose truth = PathPose(frame);
    const auto seen = tracker.Track(photographer_.At(truth, frame), std::nullopt);
    ASSERT_TRUE(seen) << frame;
    EXPECT_EQ(seen->found, frame == 0) << frame;
    EXPECT_TRUE(seen->registered);
    const Eigen::Matrix<double, 6, 1> off = Between(truth, seen->X_CT);
    EXPECT_LT(off.head<3>().norm(), 0.004) << frame;
    EXPECT_LT(Degrees(off.tail<3>().norm()), 0.12) << frame;
    EXPECT_LT(seen->residual_px, 0.3) << frame;
    EXPECT_GT(seen->visible, 0.5) << frame;
    EXPECT_LE(seen->visible, 1) << frame;
    EXPECT_EQ(tracker.inlier_points().size(), static_cast<std::size_t>(seen->inliers));
    nees += off.dot(seen->covariance.inverse() * off) / kFrames;
  }
  EXPECT_LT(nees, 6 + 4 * std::sqrt(2 * 6.0 / kFrames));
}

TEST_F(PadAlignmentTest, FollowsThePadAtEveryHeight) {
  for (const double height : {0.8, 1.2, 2.0, 3.0, 6.0, 9.0, 13.0}) {
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 4; ++frame) {
      const Pose truth =
          PadBelow({0.02 * frame, -0.01 * frame, height + 0.02 * frame}, 3 + frame, 0.5 * frame);
      const auto seen = tracker.Track(photographer_.At(truth, frame), truth);
      ASSERT_TRUE(seen) << height;
      EXPECT_FALSE(seen->found) << height;
      const Vector3d off = seen->X_CT.p - truth.p;
      EXPECT_LT(off.head<2>().norm(), 0.0002 * height + 0.0005) << height;
      EXPECT_LT(std::abs(off.z()), 0.0003 * height * height + 0.001) << height;
    }
  }
}

TEST_F(PadAlignmentTest, SaysNoneWhileThePadIsHiddenAndFindsItAgain) {
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 12; ++frame) {
    const Pose truth = PathPose(frame);
    const bool hidden = frame >= 3 && frame < 9;
    const auto seen = tracker.Track((hidden ? ground_ : photographer_).At(truth, frame), std::nullopt);
    ASSERT_EQ(seen.has_value(), !hidden) << frame;
    if (hidden) {
      EXPECT_TRUE(tracker.inlier_points().empty());
      continue;
    }
    EXPECT_EQ(seen->found, frame == 0 || frame == 9) << frame;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.004) << frame;
  }
}

TEST_F(PadAlignmentTest, AnotherPictureIsNoPadEvenWhereItIsExpected) {
  cv::Mat mirrored;
  cv::flip(PadPicture(), mirrored, 1);
  const PadPhotographer mirror(mirrored), white(cv::Mat(1190, 910, CV_8UC1, cv::Scalar(255)));
  for (const PadPhotographer* scene : {&ground_, &mirror, &white}) {
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 2; ++frame)
      EXPECT_FALSE(tracker.Track(scene->At(PathPose(frame), frame), PathPose(frame)));
  }
}

// It goes to and fro by up to 25 px from image to image, 15 of them while the shutter is open.
TEST_F(PadAlignmentTest, FollowsAPadThatItsMotionBlurs) {
  constexpr int kInstants = 12, kFrames = 24;
  constexpr double kExposure = 0.6;  // of the time between images
  const auto pose = [](double frame) {
    const double begin = std::min(1.0, frame / 8);
    return PadBelow({begin * 0.55 * std::sin(0.22 * frame), begin * 0.2 * std::sin(0.15 * frame), 4},
                    20 + frame);
  };
  for (const char* method : {"klt", "icia"}) {
    PadTracker tracker{reference_, kPadCamera, {.method = method}};
    for (int frame = 0; frame < kFrames; ++frame) {
      cv::Mat sum(kPadCamera.height_px, kPadCamera.width_px, CV_32FC1, cv::Scalar(0)), image;
      for (int i = 0; i < kInstants; ++i)
        cv::accumulate(
            photographer_.At(pose(frame + kExposure * ((i + 0.5) / kInstants - 0.5)), 100 * frame + i), sum);
      sum.convertTo(image, CV_8U, 1.0 / kInstants);
      const auto seen = tracker.Track(image, frame == 0 ? std::optional(pose(0)) : std::nullopt);
      ASSERT_TRUE(seen) << method << " " << frame;
      EXPECT_FALSE(seen->found) << method << " " << frame;
      EXPECT_LT((seen->X_CT.p - pose(frame).p).head<2>().norm(), 0.01) << method << " " << frame;  // 2 px
    }
  }
}

TEST_F(PadAlignmentTest, LightThatChangesAndASheetOverAThirdDoNotLoseIt) {
  cv::Mat picture = PadPicture();
  picture.rowRange(2 * picture.rows / 3, picture.rows).setTo(15);
  const PadPhotographer covered(picture);
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 12; ++frame) {
    const Pose truth = PathPose(frame, 3.5);
    const bool dim = frame >= 3 && frame < 6, sheet = frame >= 8;
    const cv::Mat image = (sheet ? covered : photographer_).At(truth, frame, dim ? 0.6 : 1, dim ? 25 : 0);
    const auto seen = tracker.Track(image, std::nullopt);
    ASSERT_TRUE(seen) << frame;
    EXPECT_EQ(seen->found, frame == 0) << frame;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), sheet ? 0.008 : 0.004) << frame;
    EXPECT_LT(seen->visible, sheet ? 0.75 : 1.0) << frame;
  }
}

}  // namespace
}  // namespace kestrel::vision
