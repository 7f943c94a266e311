// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/composition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/vision/enhance/mosaic/drawn_ground.h"

namespace kestrel::vision {
namespace {

const DrawnGround& Ground() {
  static const DrawnGround ground;
  return ground;
}

constexpr int kImages = 10;
Pose PoseAt(int i) { return DrawnGround::Above(-3 + 0.6 * i, 0.2 * std::sin(i), 10); }

// Images to the north, each passed through `change`.
template <class Change>
Mosaic MosaicOf(const Change& change) {
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.keyframe_overlap = 0.9;  // nearly every image
  Mosaic mosaic(options);
  for (int i = 0; i < kImages; ++i) {
    cv::Mat image = Ground().Draw(PoseAt(i));
    change(i, image);
    EXPECT_TRUE(IsPlaced(mosaic.Add(image, i, PoseAt(i)).state)) << i;
  }
  mosaic.Adjust();
  return mosaic;
}
Mosaic AsItIs() {
  return MosaicOf([](int, cv::Mat&) {});
}

// Mean absolute difference from the ground's own picture, grey levels.
double Difference(const Mosaic& mosaic, const MosaicPicture& picture, int* compared = nullptr) {
  const Eigen::Matrix3d ground = *mosaic.GroundFromSurface();
  double difference = 0;
  int n = 0;
  for (int y = 10; y < picture.image.rows - 10; y += 3)
    for (int x = 10; x < picture.image.cols - 10; x += 3) {
      if (!picture.shown.at<std::uint8_t>(y, x)) continue;
      const Eigen::Vector2d at = picture.origin + picture.scale * Eigen::Vector2d(x, y);
      const Eigen::Vector3d N = ground * Eigen::Vector3d(at.x(), at.y(), 1);
      const cv::Point2f p(static_cast<float>(N.y() / DrawnGround::kPixel_m + Ground().picture.cols / 2.0),
                          static_cast<float>(-N.x() / DrawnGround::kPixel_m + Ground().picture.rows / 2.0));
      cv::Mat one;
      cv::getRectSubPix(Ground().picture, {1, 1}, p, one);
      difference += std::abs(picture.image.at<std::uint8_t>(y, x) - one.at<std::uint8_t>(0));
      ++n;
    }
  if (compared) *compared = n;
  return difference / std::max(n, 1);
}

TEST(CompositionTest, EveryComposerShowsTheGround) {
  const Mosaic mosaic = AsItIs();
  for (const Composer composer : {Composer::kAverage, Composer::kFeather, Composer::kNearest,
                                  Composer::kMedian, Composer::kSeams, Composer::kMultiBand}) {
    int compared = 0;
    const MosaicPicture picture = Compose(mosaic, {.composer = composer});
    EXPECT_LT(Difference(mosaic, picture, &compared), 6) << static_cast<int>(composer);
    EXPECT_GT(compared, 12000) << static_cast<int>(composer);
    // It has no holes.
    cv::Mat shown = picture.shown(cv::Rect(20, 20, picture.shown.cols - 40, picture.shown.rows - 40));
    EXPECT_GT(cv::countNonZero(shown), 0.98 * static_cast<double>(shown.total()))
        << static_cast<int>(composer);
  }
}

// A black square goes over the images, each time elsewhere.
TEST(CompositionTest, WhatMovesIsNotInTheMedian) {
  const Mosaic mosaic = MosaicOf([](int i, cv::Mat& image) {
    cv::rectangle(image, cv::Rect(20 + 27 * i, 60 + 70 * (i % 2), 36, 36), cv::Scalar(0), cv::FILLED);
  });
  const auto black = [](const MosaicPicture& picture) {
    cv::Mat blurred;
    cv::blur(picture.image, blurred, {15, 15});
    return cv::countNonZero((blurred < 25) & picture.shown);
  };
  const MosaicPicture nearest = Compose(mosaic, {.composer = Composer::kNearest, .exposure = false});
  const MosaicPicture median = Compose(mosaic, {.composer = Composer::kMedian, .exposure = false});
  EXPECT_GT(black(nearest), 200);  // it is there to be removed
  EXPECT_LT(black(median), black(nearest) / 5);
}

TEST(CompositionTest, ExposuresAreMadeToAgree) {
  const Mosaic mosaic =
      MosaicOf([](int i, cv::Mat& image) { image.convertTo(image, -1, i % 2 ? 0.75 : 1.0); });
  // Of the difference between neighbours: by how much columns of the picture differ from the ground's, up to a gain.
  const auto unevenness = [&](bool exposure) {
    const MosaicPicture picture = Compose(mosaic, {.composer = Composer::kNearest, .exposure = exposure});
    const MosaicPicture even = Compose(AsItIs(), {.composer = Composer::kNearest, .exposure = false});
    std::vector<double> ratios;
    const int rows = std::min(picture.image.rows, even.image.rows);
    for (int y = 20; y + 20 < rows; y += 20)
      ratios.push_back(cv::mean(picture.image.rowRange(y, y + 20))[0] /
                       cv::mean(even.image.rowRange(y, y + 20))[0]);
    double mean = 0, squares = 0;
    for (const double r : ratios) mean += r / static_cast<double>(ratios.size());
    for (const double r : ratios) squares += (r - mean) * (r - mean) / static_cast<double>(ratios.size());
    return std::sqrt(squares) / mean;
  };
  const double before = unevenness(false), after = unevenness(true);
  EXPECT_GT(before, 0.05);
  EXPECT_LT(after, before / 2);
}

TEST(CompositionTest, IsScaledDownToItsMemory) {
  const Mosaic mosaic = AsItIs();
  const MosaicPicture whole = Compose(mosaic, {.composer = Composer::kFeather});
  const MosaicPicture small = Compose(mosaic, {.composer = Composer::kFeather, .most_bytes = 1'000'000});
  EXPECT_EQ(whole.scale, 1);
  EXPECT_EQ(small.scale, 2);
  EXPECT_NEAR(small.image.cols, whole.image.cols / 2.0, 2);
  EXPECT_LT(Difference(mosaic, small), 12);
}

TEST(CompositionTest, TheSameBitsOnAnyNumberOfThreads) {
  const Mosaic mosaic = AsItIs();
  const int threads = cv::getNumThreads();
  for (const Composer composer : {Composer::kMedian, Composer::kMultiBand}) {
    cv::setNumThreads(1);
    const MosaicPicture one = Compose(mosaic, {.composer = composer});
    cv::setNumThreads(4);
    const MosaicPicture four = Compose(mosaic, {.composer = composer});
    ASSERT_EQ(one.image.size(), four.image.size());
    EXPECT_EQ(cv::norm(one.image, four.image, cv::NORM_INF), 0);
  }
  cv::setNumThreads(threads);
}

}  // namespace
}  // namespace kestrel::vision
