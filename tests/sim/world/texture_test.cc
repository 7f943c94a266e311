// SPDX-License-Identifier: Apache-2.0
#include "sim/world/texture.h"

#include <gtest/gtest.h>

#include <bit>

namespace kestrel::sim {
namespace {

// Where a row or column passes from dark to light, in shares of its length.
double Edge(const cv::Mat& line) {
  double dark = 0;
  for (int i = 0; i < static_cast<int>(line.total()); ++i) dark += 1 - line.at<uchar>(i) / 255.0;
  return dark / static_cast<double>(line.total());
}

TEST(Texture, HasSidesOfPowersOfTwoAndShowsTheSameFromEdgeToEdge) {
  for (const cv::Size size :
       {cv::Size(300, 200), cv::Size(1000, 64), cv::Size(5000, 600), cv::Size(33, 4097)}) {
    cv::Mat picture(size, CV_8UC1, cv::Scalar(255));
    const int right = size.width / 3, down = size.height / 4;
    picture.colRange(0, right).setTo(0);
    picture.rowRange(0, down).setTo(0);
    const cv::Mat texture = TexturePicture(picture);
    EXPECT_TRUE(std::has_single_bit(static_cast<unsigned>(texture.cols))) << size;
    EXPECT_TRUE(std::has_single_bit(static_cast<unsigned>(texture.rows))) << size;
    EXPECT_LE(std::max(texture.cols, texture.rows), 4096);
    EXPECT_NEAR(Edge(texture.row(texture.rows - 1).clone()), 1.0 * right / size.width,
                0.1 / std::min(size.width, 4096));
    EXPECT_NEAR(Edge(texture.col(texture.cols - 1).clone()), 1.0 * down / size.height,
                0.1 / std::min(size.height, 4096));
  }
}

TEST(Texture, OfAPictureThatIsOneAlreadyIsThePicture) {
  cv::Mat picture(64, 128, CV_8UC1);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 256);
  EXPECT_EQ(cv::norm(TexturePicture(picture), picture, cv::NORM_INF), 0);
}

TEST(Texture, OfAPartOfAPictureHasItsPixelsWithoutGaps) {
  cv::Mat picture(64, 128, CV_8UC1);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat part = picture.colRange(32, 64), texture = TexturePicture(part);
  EXPECT_TRUE(texture.isContinuous());
  EXPECT_EQ(cv::norm(texture, part, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace kestrel::sim
