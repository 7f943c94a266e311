// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/tag.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCustom48h12.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "vision/tag/tag_detector.h"
#include "vision/tag/tag_family.h"

namespace kestrel::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Eigen::Vector2d kSheet_m(1, 1);

// A picture of a metre laid into a grey image of 640 x 480, turned, 300 px to the metre; and where a place of T
// comes to lie.
struct Laid {
  cv::Mat image{480, 640, CV_8UC1, cv::Scalar(110)};
  cv::Mat A;

  explicit Laid(const cv::Mat& picture, bool mirrored = false) {
    cv::Mat small;
    cv::resize(picture, small, {300, 300}, 0, 0, cv::INTER_AREA);
    if (mirrored) cv::flip(small, small, 1);
    A = cv::getRotationMatrix2D({149.5F, 149.5F}, 20, 1);
    A.at<double>(0, 2) += 170, A.at<double>(1, 2) += 90;
    cv::warpAffine(small, image, A, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  }
  Eigen::Vector2d At(const Eigen::Vector2d& p_T) const {
    const Eigen::Vector3d uv((p_T.y() + 0.5) * 300 - 0.5, (0.5 - p_T.x()) * 300 - 0.5, 1);
    return {A.at<double>(0, 0) * uv.x() + A.at<double>(0, 1) * uv.y() + A.at<double>(0, 2),
            A.at<double>(1, 0) * uv.x() + A.at<double>(1, 1) * uv.y() + A.at<double>(1, 2)};
  }
};

// As large as fits on the sheet, and some to spare.
Tag LargeTag(const std::string& name, int id) {
  const TagFamily family = TagFamilyOf(name);
  return {name, id, 0.8 * family.border_cells / family.total_cells, {0.02, -0.03}};
}

TEST(Tag, OfEveryFamilyIsFoundWhereItWasDrawn) {
  int families = 0;
  for (const std::string& name : TagFamilyNames()) {
    const Tag tag = LargeTag(name, 7);
    const Laid laid(DrawTags({tag}, kSheet_m));
    const auto found = TagDetector({tag}).Detect(laid.image);
    ASSERT_EQ(found.size(), 1u) << name;
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_LT((found[0].corners[k] - laid.At(CornersOf(tag)[k])).norm(), 0.3) << name << k;
    ++families;
  }
  EXPECT_EQ(families, 26);
}

TEST(Tag, OpenCvReadsTheSameTagWhereItWasDrawn) {
  const std::vector<std::pair<std::string, int>> families = {
      {"tag36h11", cv::aruco::DICT_APRILTAG_36h11}, {"tag25h9", cv::aruco::DICT_APRILTAG_25h9},
      {"tag16h5", cv::aruco::DICT_APRILTAG_16h5},   {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
      {"DICT_5X5_100", cv::aruco::DICT_5X5_100},    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
      {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000}};
  for (const auto& [name, number] : families) {
    const Tag tag = LargeTag(name, 13);
    const Laid laid(DrawTags({tag}, kSheet_m));
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(laid.image,
                             cv::makePtr<cv::aruco::Dictionary>(cv::aruco::getPredefinedDictionary(number)),
                             corners, ids);
    ASSERT_THAT(ids, ElementsAre(13)) << name;
    // OpenCV's tables have the tags of AprilTag upside down.
    const std::size_t first = name.starts_with("tag") ? 2 : 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const cv::Point2f& corner = corners[0][(first + k) % 4];
      const Eigen::Vector2d there(corner.x, corner.y);
      EXPECT_LT((there - laid.At(CornersOf(tag)[k])).norm(), 2) << name << k;  // OpenCV's are not refined
    }
  }
}

TEST(Tag, OfAprilTagIsWhatItsOwnLibraryDraws) {
  const auto compare = [](const char* name, apriltag_family_t* family, void (*destroy)(apriltag_family_t*)) {
    image_u8_t* const drawn = apriltag_to_image(family, 11);
    const cv::Mat theirs(drawn->height, drawn->width, CV_8UC1, drawn->buf,
                         static_cast<std::size_t>(drawn->stride));
    const cv::Mat ours = CellsOfTag(TagFamilyOf(name), 11);
    ASSERT_EQ(ours.size(), theirs.size()) << name;
    cv::Mat off;
    cv::absdiff(ours, theirs, off);
    off.setTo(0, ours == kHoleCell);
    EXPECT_EQ(cv::countNonZero(off), 0) << name;
    std::free(drawn->buf);  // as image_u8_destroy does, which is in a library of its own
    std::free(drawn);
    destroy(family);
  };
  compare("tag36h11", tag36h11_create(), tag36h11_destroy);
  compare("tagCustom48h12", tagCustom48h12_create(), tagCustom48h12_destroy);
}

TEST(Tag, OfAnotherNumberOrMirroredIsNone) {
  const Tag mine = LargeTag("tag36h11", 3), other = LargeTag("tag36h11", 4);
  const TagDetector detector({mine});
  EXPECT_EQ(detector.Detect(Laid(DrawTags({mine}, kSheet_m)).image).size(), 1u);
  EXPECT_TRUE(detector.Detect(Laid(DrawTags({other}, kSheet_m)).image).empty());
  EXPECT_TRUE(detector.Detect(Laid(DrawTags({mine}, kSheet_m), true).image).empty());
}

TEST(Tag, NestedInAnotherBothAreRead) {
  const std::vector<Tag> tags = {{"tagCustom48h12", 0, 0.54, {0, 0}}, {"tag36h11", 0, 0.144, {0, 0}}};
  Mistakes mistakes;
  CheckTags(tags, kSheet_m, "pad.yaml", "tags", mistakes);
  EXPECT_TRUE(mistakes.empty()) << testing::PrintToString(mistakes.Texts());
  EXPECT_EQ(TagDetector(tags).Detect(Laid(DrawTags(tags, kSheet_m)).image).size(), 2u);
}

TEST(Tag, WhatNoPadCanHaveIsRefused) {
  const auto refusal = [](const std::vector<Tag>& tags) {
    Mistakes mistakes;
    CheckTags(tags, kSheet_m, "pad.yaml", "tags", mistakes);
    return mistakes.Texts();
  };
  EXPECT_THAT(refusal({{"tag36h11", 587, 0.5, {0, 0}}}), ElementsAre(HasSubstr("valid: 0 to 586")));
  EXPECT_THAT(refusal({{"tag36h11", 0, 0.9, {0, 0}}}), ElementsAre(HasSubstr("0.0625 m beyond the picture")));
  EXPECT_THAT(refusal({{"tag36h11", 0, 0.7, {0, 0}}, {"tag36h11", 1, 0.1, {0, 0}}}),
              ElementsAre(AllOf(HasSubstr("tags[1]: hides a part of tags[0]"), HasSubstr("tagCustom48h12"))));
  EXPECT_THAT(refusal({{"tag36h11", 0, 0.3, {0.3, 0.3}}, {"tag36h11", 0, 0.3, {-0.3, -0.3}}}),
              ElementsAre(HasSubstr("valid: another id")));
  EXPECT_THAT(refusal({{"DICT_ARUCO_ORIGINAL", 1023, 0.5, {0, 0}}}), ElementsAre(HasSubstr("turned")));
}

}  // namespace
}  // namespace kestrel::vision
