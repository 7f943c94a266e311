// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bench/planar/planar_pictures.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;

Matrix3d Shifted(const Matrix3d& H_w, double u) {
  Matrix3d shift = Matrix3d::Identity();
  shift(0, 2) = u;
  return shift * H_w;
}

// As if drawn: one homography throughout, and how much of the picture is to be seen.
std::vector<PlanarFrame> Frames(const std::vector<double>& visible) {
  Matrix3d H_w;
  H_w << 0, 200, 320, -200, 0, 240, 0, 0, 1;
  std::vector<PlanarFrame> frames;
  for (const double share : visible) frames.push_back({cv::Mat(8, 8, CV_8UC1, cv::Scalar(0)), H_w, share});
  return frames;
}

// Off by so many pixels in each frame after the first; NaN: no answer.
PlanarScore Scored(const std::vector<double>& visible, const std::vector<double>& off_px) {
  const std::vector<PlanarFrame> frames = Frames(visible);
  std::size_t next = 0;
  const PlanarTracker tracker{"made up", true, [](const cv::Mat&, const Matrix3d&) {},
                              [&](const cv::Mat&) -> std::optional<Matrix3d> {
                                const double off = off_px[next++];
                                if (std::isnan(off)) return std::nullopt;
                                return Shifted(frames.front().H_w, off);
                              }};
  return ScoreOf(tracker, frames);
}

TEST(PlanarScore, AlignmentErrorIsThatOfTheCorners) {
  const Matrix3d H = Frames({1}).front().H_w;
  EXPECT_NEAR(AlignmentError_px(H, H), 0, 1e-12);
  EXPECT_NEAR(AlignmentError_px(Shifted(H, 3), H), 3, 1e-9);
  Matrix3d larger = H;  // by a tenth, about the middle: each corner moves by a tenth of its distance from it
  larger.col(0) *= 1.1, larger.col(1) *= 1.1;
  EXPECT_NEAR(AlignmentError_px(larger, H), 0.1 * 200 * std::hypot(0.45, 0.6), 1e-9);
  EXPECT_EQ(AlignmentError_px(Matrix3d::Zero(), H), std::numeric_limits<double>::infinity());
}

TEST(PlanarScore, CountsWhatIsRightAndLostWhileThePictureIsSeen) {
  //                                   counts             hidden   counts
  const PlanarScore score = Scored({1, 1, 1, 1, 1, 1, 0.2, 1, 1}, {0.5, 4, 20, NAN, 2, 90, 0.5, 0.5});
  EXPECT_EQ(score.error_px.size(), 7u);
  EXPECT_NEAR(score.Precision(1), 3.0 / 7, 1e-12);
  EXPECT_NEAR(score.Precision(5), 5.0 / 7, 1e-12);
  EXPECT_NEAR(score.Accuracy_px(), (0.5 + 4 + 2 + 0.5 + 0.5) / 5, 1e-9);
  EXPECT_EQ(score.losses, 1);
  EXPECT_EQ(score.ms.size(), 8u);
  EXPECT_EQ(score.gone, 0);
}

TEST(PlanarScore, TellsHowLongItTookToBeRightAgain) {
  const PlanarScore late = Scored({1, 0, 0, 0.4, 0.6, 1, 1, 1}, {NAN, 3, NAN, NAN, 8, NAN, 2});
  ASSERT_EQ(late.recovery_s.size(), 1u);
  EXPECT_NEAR(late.recovery_s[0], 3 / kPlanarRate_hz, 1e-12);  // from where half of it is seen
  EXPECT_EQ(late.gone, 2);
  EXPECT_EQ(late.imagined, 1);
  const PlanarScore never = Scored({1, 0, 1, 1}, {NAN, NAN, NAN});
  ASSERT_EQ(never.recovery_s.size(), 1u);
  EXPECT_FALSE(std::isfinite(never.recovery_s[0]));
}

// What is compared is what flies: from the drawn images, of each kind of picture.
TEST(PlanarTrackers, OursAlignsEachKindOfPictureToAPixel) {
  for (const PlanarPicture& picture : PlanarPictures(7)) {
    const PlanarSequence sequence(picture.grey, PlanarFactor::kPerspective, 7);
    std::vector<PlanarFrame> frames;
    for (int i = 0; i < 4; ++i) frames.push_back(sequence.Draw(i));
    const PlanarScore score = ScoreOf(PadPlanarTracker(picture.grey, {}, "klt"), frames);
    ASSERT_EQ(score.error_px.size(), 3u);
    EXPECT_EQ(score.Precision(1), 1) << picture.name;
  }
}

}  // namespace
}  // namespace kestrel::bench
