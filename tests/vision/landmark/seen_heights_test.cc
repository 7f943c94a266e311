// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/seen_heights.h"

#include <gtest/gtest.h>

#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::vision {
namespace {

const Eigen::Vector2d kSize_m(kPadLength_m, kPadWidth_m);

PadReference OfTags(const std::vector<Tag>& tags) {
  PadReference pad = MakePadReference(DrawTags(tags, kSize_m), kPadLength_m, kPadWidth_m);
  pad.tags = tags;
  return pad;
}

// Whether the tag itself is found, straight below the camera.
bool Found(const std::vector<Tag>& tags, const PadPhotographer& photographer, double height_m) {
  return TagTracker(tags, kPadCamera)
      .Track(photographer.At(PadBelow({0, 0, height_m}, 0), 1), std::nullopt)
      .has_value();
}

TEST(SeenHeights, OfATagAreThoseBetweenWhichItIsFound) {
  for (const Tag& tag : {Tag{"tag36h11", 0, 0.4, {0, 0}}, Tag{"DICT_5X5_50", 1, 0.4, {0, 0}},
                         Tag{"tagCustom48h12", 2, 0.3, {0, 0}}}) {
    const auto seen = HeightsSeen(OfTags({tag}), kPadCamera, {});
    ASSERT_EQ(seen.size(), 1u);
    const PadPhotographer photographer(DrawTags({tag}, kSize_m));
    EXPECT_TRUE(Found({tag}, photographer, 1.03 * seen[0].min_m)) << tag.family;
    EXPECT_FALSE(Found({tag}, photographer, 0.75 * seen[0].min_m)) << tag.family;
    EXPECT_TRUE(Found({tag}, photographer, 0.97 * seen[0].max_m)) << tag.family;
    EXPECT_FALSE(Found({tag}, photographer, 4 * seen[0].max_m)) << tag.family;
  }
}

TEST(SeenHeights, OfThePadsPictureTheUpperOneIsWhereItIsStillFound) {
  const PadReference pad = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  const auto seen = HeightsSeen(pad, kPadCamera, {});
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_LT(seen[0].min_m, 0.3);  // it has corners at every scale
  const PadPhotographer photographer(PadPicture());
  const auto found = [&](double height_m) {
    return PadTracker(pad, kPadCamera, {})
        .Track(photographer.At(PadBelow({0, 0, height_m}, 3), 1), std::nullopt);
  };
  EXPECT_TRUE(found(0.95 * seen[0].max_m));
  EXPECT_FALSE(found(2 * seen[0].max_m));
}

// An H has a dozen corners: too few to be followed by them.
TEST(SeenHeights, AsAWholeAPictureOfFewCornersIsFollowedFromNear) {
  cv::Mat picture(600, 600, CV_8UC1, cv::Scalar(60));
  cv::circle(picture, {300, 300}, 235, 250, 30, cv::LINE_AA);
  for (const cv::Rect& bar :
       {cv::Rect(190, 165, 55, 270), cv::Rect(355, 165, 55, 270), cv::Rect(190, 272, 220, 55)})
    picture(bar).setTo(250);
  const PadReference pad = MakePadReference(picture, 1.2, 1.2);
  const auto by_corners = HeightsSeen(pad, kPadCamera, {}),
             as_a_whole = HeightsSeen(pad, kPadCamera, {.method = "icia"});
  ASSERT_EQ(as_a_whole.size(), 1u);
  EXPECT_LT(as_a_whole[0].min_m, 1);
  EXPECT_GT(as_a_whole[0].max_m, 10);
  EXPECT_TRUE(by_corners.empty() || by_corners[0].min_m > 5);
}

TEST(SeenHeights, TagsFarApartInSizeLeaveAGap) {
  const auto seen = HeightsSeen(OfTags({{"tagCustom48h12", 0, 0.5, {0, 0}}, {"tag36h11", 0, 0.02, {0, 0}}}),
                                kPadCamera, {});
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_LT(seen[0].max_m, seen[1].min_m);
}

}  // namespace
}  // namespace kestrel::vision
