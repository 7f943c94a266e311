// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/pad_tracker.h"

// Pads of which fewer corners are in view than are asked for first.
namespace kestrel::vision {
namespace {

// Two bars: eight corners.
cv::Mat PictureOfBars() {
  cv::Mat picture(910, 1190, CV_8UC1, cv::Scalar(60));
  cv::rectangle(picture, {200, 180, 240, 520}, 210, cv::FILLED);
  cv::rectangle(picture, {660, 300, 330, 380}, 140, cv::FILLED);
  return picture;
}

// Shading without corners at the left, and at the right letters, which have many.
constexpr int kLettersFrom_px = 640;
cv::Mat PictureOfShadingAndLetters() {
  cv::Mat picture(1190, 910, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<uchar>(y, x) =
          cv::saturate_cast<uchar>(128 + 60 * std::sin(0.012 * x) + 60 * std::cos(0.009 * y));
  for (int row = 0; row < 6; ++row)
    cv::putText(picture, "4 K", {kLettersFrom_px + 20, 200 + 180 * row}, cv::FONT_HERSHEY_SIMPLEX, 2.5,
                row % 2 ? 20 : 235, 22);
  return picture;
}

PadTracker TrackerOf(const cv::Mat& picture) {
  return {MakePadReference(picture, kPadLength_m, kPadWidth_m), kPadCamera, {}};
}

TEST(FewCorners, APictureThatHasFewIsFollowed) {
  const cv::Mat picture = PictureOfBars();
  const PadPhotographer photographer(picture);
  PadTracker tracker = TrackerOf(picture);
  for (int frame = 0; frame < 12; ++frame) {
    const Pose truth = PathPose(frame);
    const auto seen = tracker.Track(photographer.At(truth, frame), truth);
    ASSERT_TRUE(seen) << frame;
    EXPECT_EQ(seen->inliers, 8) << frame;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.003) << frame;
  }
}

TEST(FewCorners, WhereAllThatHasThemIsHiddenTheRestIsFollowed) {
  const cv::Mat picture = PictureOfShadingAndLetters();
  cv::Mat hidden = picture.clone();
  hidden.colRange(kLettersFrom_px, hidden.cols).setTo(100);
  const PadPhotographer open(picture), covered(hidden);
  PadTracker tracker = TrackerOf(picture);
  for (int frame = 0; frame < 12; ++frame) {
    const Pose truth = PathPose(frame);
    const auto seen = tracker.Track((frame < 2 ? open : covered).At(truth, frame), std::nullopt);
    ASSERT_TRUE(seen) << frame;
    EXPECT_EQ(seen->found, frame == 0) << frame;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.006) << frame;
  }
}

}  // namespace
}  // namespace kestrel::vision
