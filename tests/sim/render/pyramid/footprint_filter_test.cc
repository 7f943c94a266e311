// SPDX-License-Identifier: Apache-2.0
#include "sim/render/pyramid/footprint_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/random.h"

namespace kestrel::sim::ray {
namespace {

// Shards of all grey levels, with sharp edges, as of a pad.
cv::Mat Shards() {
  RandomStream random(3, "shards");
  cv::Mat picture(96, 96, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 400; ++i) {
    const auto at = [&] { return static_cast<int>(random.Uniform(-8, 96)); };
    const auto side = [&] { return static_cast<int>(random.Uniform(2, 12)); };
    cv::rectangle(picture, cv::Rect(at(), at(), side(), side()), cv::Scalar(random.Uniform(0, 255)),
                  cv::FILLED);
  }
  return picture;
}

double Between(const cv::Mat& picture, double x, double y) {
  const int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  const double right = x - u, down = y - v;
  const auto texel = [&](int column, int row) {
    return static_cast<double>(
        picture.at<uchar>((row + picture.rows) % picture.rows, (column + picture.cols) % picture.cols));
  };
  return (1 - down) * ((1 - right) * texel(u, v) + right * texel(u + 1, v)) +
         down * ((1 - right) * texel(u, v + 1) + right * texel(u + 1, v + 1));
}

// Of what is interpolated between the texels, from the mean of the picture over squares: grey levels.
double ErrorOf(const cv::Mat& texels, const cv::Mat& picture, double footprint) {
  constexpr int kPlaces = 12, kAcross = 12;
  RandomStream random(4, "places");
  double sum = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const double x = random.Uniform(0, 96), y = random.Uniform(0, 96);
    double mean = 0;
    for (int k = 0; k < kAcross * kAcross; ++k)
      mean += Between(picture, x + ((k % kAcross + 0.5) / kAcross - 0.5) * footprint,
                      y + (static_cast<int>(k / kAcross) + 0.5 - kAcross / 2.0) / kAcross * footprint);
    sum += std::abs(Between(texels, x, y) - mean / (kAcross * kAcross));
  }
  return sum / (kPlaces * kPlaces);
}

TEST(FootprintFilter, IsNearerToTheMeanOverTheFootprintThanAMixOfTwoSizes) {
  const cv::Mat picture = Shards();
  cv::Mat half, blurred;
  cv::resize(picture, half, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::resize(half, blurred, picture.size(), 0, 0, cv::INTER_LINEAR);
  for (const double footprint : {1.1, 1.3, 1.6, 1.9}) {
    cv::Mat mixed;
    const double share = std::log2(footprint);
    cv::addWeighted(picture, 1 - share, blurred, share, 0, mixed);
    const cv::Mat filtered = Filtered(picture, {0, picture.rows}, FilterFor(footprint, true), true);
    const double error = ErrorOf(filtered, picture, footprint);
    EXPECT_LT(error, 0.8 * ErrorOf(mixed, picture, footprint)) << footprint;
    EXPECT_LT(error, ErrorOf(picture, picture, footprint)) << footprint;
  }
}

TEST(FootprintFilter, LeavesAnEvenPictureAsItIs) {
  const cv::Mat even(5, 7, CV_8UC3, cv::Scalar(0, 128, 255));
  for (const bool original : {false, true})
    for (const double footprint : {1.0, 1.5, 2.0})
      for (const bool repeats : {false, true})
        EXPECT_EQ(cv::norm(Filtered(even, {0, 5}, FilterFor(footprint, original), repeats), even), 0);
}

TEST(FootprintFilter, ASmallerSizeIsSharpenedAtFootprintsOfOneTexel) {
  EXPECT_GT(FilterFor(1.1, false)[0], 4096);
  EXPECT_LT(FilterFor(1.9, true)[0], 4096);
}

// Also where there are fewer texels than the filter reaches.
TEST(FootprintFilter, BeginsAnewBeyondTheEdgeOrGoesOnWithIt) {
  const FootprintFilter filter{1024, 768, 512, 256};
  const cv::Mat row = (cv::Mat_<uchar>(1, 4) << 0, 0, 0, 64);
  const auto at_0 = [&](bool repeats) { return Filtered(row, {0, 1}, filter, repeats).at<uchar>(0, 0); };
  EXPECT_EQ(at_0(true), 64 * (768 + 256) / 4096);  // one to the left of it, and three to the right
  EXPECT_EQ(at_0(false), 64 * 256 / 4096);
  const cv::Mat pair = (cv::Mat_<uchar>(1, 2) << 0, 64);
  EXPECT_EQ(Filtered(pair, {0, 1}, filter, true).at<uchar>(0, 0), 64 * 2 * (768 + 256) / 4096);
}

TEST(FootprintFilter, FiltersSomeRowsAsItDoesAll) {
  const cv::Mat picture = Shards();
  const FootprintFilter filter = FilterFor(1.6, true);
  const cv::Mat all = Filtered(picture, {0, picture.rows}, filter, true);
  EXPECT_EQ(cv::norm(Filtered(picture, {64, 96}, filter, true), all.rowRange(64, 96)), 0);
  cv::Mat colours, parts[3];
  cv::merge(std::vector<cv::Mat>{picture, picture, picture}, colours);
  cv::split(Filtered(colours, {0, picture.rows}, filter, true), parts);
  for (const cv::Mat& part : parts) EXPECT_EQ(cv::norm(part, all), 0);
}

}  // namespace
}  // namespace kestrel::sim::ray
