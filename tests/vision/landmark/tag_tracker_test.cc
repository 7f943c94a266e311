// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/tag_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/vision/landmark/pad_photographer.h"
#include "tests/vision/landmark/pose_difference.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::vision {
namespace {

const Eigen::Vector2d kSize_m(kPadLength_m, kPadWidth_m);
// Of 0.9 m, 0.18 m and 0.036 m with what is around their squares.
const std::vector<Tag> kNested = {{"tagCustom48h12", 0, 0.54, {0, 0}},
                                  {"tagCustom48h12", 1, 0.108, {0, 0}},
                                  {"tag36h11", 0, 0.0288, {0, 0}}};

const PadPhotographer& Nested() {
  static const PadPhotographer photographer(DrawTags(kNested, kSize_m));
  return photographer;
}

TEST(TagTracker, OneOfNestedTagsIsSeenAtEveryHeight) {
  for (const double height : {0.15, 0.25, 0.4, 0.7, 1.2, 2.0, 4.0, 8.0, 12.0}) {
    TagTracker tracker(kNested, kPadCamera);
    const Pose truth = PadBelow({0.005, -0.003, height}, 12, 1, -2);
    const auto seen = tracker.Track(Nested().At(truth, 1), std::nullopt);
    ASSERT_TRUE(seen) << height;
    const Eigen::Vector3d off = seen->pose.X_CT.p - truth.p;
    EXPECT_LT(off.head<2>().norm(), 0.0006 * height + 0.0003) << height;
    EXPECT_LT(std::abs(off.z()), 0.002 * height * std::max(1.0, height / 2)) << height;
  }
}

TEST(TagTracker, CovarianceCoversTheErrors) {
  TagTracker tracker(kNested, kPadCamera);
  double nees = 0;
  constexpr int kFrames = 24;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Pose truth =
        PadBelow({0.05 - 0.004 * frame, 0.003 * frame, 0.5 + 0.15 * frame}, 5.0 * frame, 0.3 * frame, -4);
    const auto seen = tracker.Track(Nested().At(truth, frame), truth);
    ASSERT_TRUE(seen) << frame;
    const Eigen::Matrix<double, 6, 1> off = Between(truth, seen->pose.X_CT);
    nees += off.dot(seen->pose.covariance.inverse() * off) / kFrames;
  }
  EXPECT_GT(nees, 0.25);
  EXPECT_LT(nees, 6 + 4 * std::sqrt(2 * 6.0 / kFrames));
}

TEST(TagTracker, ABoardIsKnownBetterThanOneOfItsTags) {
  std::vector<Tag> board;
  for (int i = 0; i < 4; ++i)
    board.push_back({"DICT_5X5_100", i, 0.3, {i < 2 ? 0.3 : -0.3, i % 2 == 0 ? -0.2 : 0.2}});
  const PadPhotographer photographer(DrawTags(board, kSize_m));
  const Pose truth = PadBelow({0.1, 0, 3}, 30, 10);
  const cv::Mat image = photographer.At(truth, 3);
  const auto one = TagTracker({board[0]}, kPadCamera).Track(image, std::nullopt),
             all = TagTracker(board, kPadCamera).Track(image, std::nullopt);
  ASSERT_TRUE(one && all);
  EXPECT_EQ(all->tags, 4);
  EXPECT_EQ(all->corners.size(), 16u);
  EXPECT_LT(all->pose.covariance.trace(), one->pose.covariance.trace() / 4);
  EXPECT_LT((all->pose.X_CT.p - truth.p).norm(), 0.01);
}

// A square of 30 px whose two tilts fit alike.
TEST(TagTracker, OfTwoTiltsThatFitAlikeTheExpectedOneIsTaken) {
  const std::vector<Tag> tags = {{"tag36h11", 0, 0.15, {0, 0}}};
  const PadPhotographer photographer(DrawTags(tags, kSize_m));
  for (const double tilt_deg : {-8.0, 8.0}) {
    const Pose truth = PadBelow({0, 0, 4}, 10, tilt_deg);
    TagTracker tracker(tags, kPadCamera);
    const auto seen = tracker.Track(photographer.At(truth, 5), truth);
    ASSERT_TRUE(seen);
    EXPECT_LT(Degrees(seen->pose.X_CT.R.angularDistance(truth.R)), 8) << tilt_deg;
  }
}

// Too near for the whole tag: its picture is registered, by its corners or as a whole.
class TagsByMethod : public testing::TestWithParam<const char*> {};

TEST_P(TagsByMethod, APadTrackerFollowsASingleTagBelowTheHeightAtWhichItFits) {
  const std::vector<Tag> tags = {{"tag36h11", 5, 0.72, {0, 0}}};
  const cv::Mat picture = DrawTags(tags, kSize_m);
  PadReference reference = MakePadReference(picture, kPadLength_m, kPadWidth_m);
  reference.tags = tags;
  PadTracker tracker(reference, kPadCamera, {.method = GetParam()});
  const PadPhotographer photographer(picture);
  int whole = 0, part = 0;
  for (int frame = 0; frame < 14; ++frame) {
    const Pose truth = PadBelow({0.02, 0.01, 1.6 - 0.05 * frame}, 4);
    const auto seen = tracker.Track(photographer.At(truth, frame), truth);
    ASSERT_TRUE(seen) << frame;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.01) << frame;
    ++(seen->inliers == 4 ? whole : part);
  }
  EXPECT_GT(whole, 3);
  EXPECT_GT(part, 3);
}
INSTANTIATE_TEST_SUITE_P(TagTracker, TagsByMethod, testing::Values("klt", "icia"));

}  // namespace
}  // namespace kestrel::vision
