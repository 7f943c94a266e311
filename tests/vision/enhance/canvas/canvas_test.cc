// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/canvas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/camera/pinhole.h"
#include "vision/enhance/canvas/blending.h"
#include "vision/enhance/canvas/projection.h"

namespace kestrel::vision {
namespace {

constexpr std::int64_t kTileBytes = 256 * 256 * 2 * 4;  // of a grey canvas

cv::Mat Grey(cv::Size size, int grey) { return {size, CV_8UC1, cv::Scalar(grey)}; }
cv::Mat Weights(cv::Size size, float weight) { return {size, CV_32FC1, cv::Scalar(weight)}; }

TEST(BlendWeightTest, FeatherIsTheQuadraticFilterOfTheThesis) {
  const cv::Size size(640, 480);
  EXPECT_NEAR(BlendWeight(Blending::kFeather, size, 319.5, 239.5), 1, 1e-6);
  for (const double u : {0.0, 100.0, 400.0, 630.0})
    for (const double v : {3.0, 200.0, 470.0}) {
      const double x = (u - 319.5) / 320, y = (v - 239.5) / 240;
      EXPECT_NEAR(BlendWeight(Blending::kFeather, size, u, v), (1 - x * x) * (1 - y * y), 1e-5);
    }
  EXPECT_EQ(BlendWeight(Blending::kFeather, size, -0.1, 100), 0);
  EXPECT_EQ(BlendWeight(Blending::kFeather, size, 100, 479.1), 0);
  EXPECT_GT(BlendWeight(Blending::kFeather, size, 0, 0), 0);
}

TEST(BlendWeightTest, NearestFallsWithTheDistanceFromTheMiddleAlone) {
  const cv::Size size(640, 480);
  double last = 2;
  for (double r = 0; r < 230; r += 10) {
    const double weight = BlendWeight(Blending::kNearest, size, 319.5 + 0.6 * r, 239.5 + 0.8 * r);
    EXPECT_LT(weight, last);
    EXPECT_NEAR(weight, BlendWeight(Blending::kNearest, size, 319.5 - r, 239.5), 1e-5);
    last = weight;
  }
}

TEST(BlendWeightTest, OfAMapAreThoseOfItsPlaces) {
  const cv::Size size(100, 80);
  const PixelMap map = MakePixelMap({-10, -10, 120, 100}, 8, [](const Eigen::Vector2d& p) {
    return std::optional<Eigen::Vector2d>(p + Eigen::Vector2d(0.25, 0.5));
  });
  for (const Blending blending : {Blending::kAverage, Blending::kFeather, Blending::kNearest}) {
    const cv::Mat weights = BlendWeights(blending, size, map);
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 120; ++x)
        ASSERT_NEAR(weights.at<float>(y, x), BlendWeight(blending, size, x - 10 + 0.25, y - 10 + 0.5), 1e-5);
  }
}

TEST(PixelMapTest, IsExactAtItsStepsAndNearBetweenThem) {
  const auto source = [](const Eigen::Vector2d& p) -> std::optional<Eigen::Vector2d> {
    if (p.x() + p.y() > 150) return std::nullopt;
    return Eigen::Vector2d(p.x() + 1e-3 * p.y() * p.y(), p.y() - 2e-3 * p.x() * p.x());
  };
  const cv::Rect part(-20, 5, 131, 90);
  const PixelMap map = MakePixelMap(part, 8, source);
  int nowhere = 0;
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      const auto is = source({part.x + x, part.y + y});
      const float u = map.u.at<float>(y, x), v = map.v.at<float>(y, x);
      if (!is) {
        ASSERT_EQ(u, PixelMap::kNowhere);
        ++nowhere;
        continue;
      }
      const double most =
          x % 8 == 0 && y % 8 == 0 ? 1e-4 : 64.0 / 8 * 4e-3 + 1e-3;  // h^2 / 8 times the curvature
      ASSERT_NEAR(u, is->x(), most);
      ASSERT_NEAR(v, is->y(), most);
    }
  EXPECT_GT(nowhere, 100);
}

TEST(CanvasTest, MeanIsWeighted) {
  Canvas canvas(Blending::kFeather, 1, 100 * kTileBytes);
  canvas.Draw({-300, 40, 500, 400}, Grey({500, 400}, 100), Weights({500, 400}, 1));
  canvas.Draw({-100, 40, 500, 400}, Grey({500, 400}, 200), Weights({500, 400}, 3));
  const MosaicPicture picture = canvas.Picture();
  EXPECT_EQ(picture.image.size(), cv::Size(700, 400));
  EXPECT_EQ(picture.origin, Eigen::Vector2d(-300, 40));
  EXPECT_EQ(picture.scale, 1);
  EXPECT_EQ(picture.image.at<std::uint8_t>(10, 10), 100);
  EXPECT_EQ(picture.image.at<std::uint8_t>(10, 300), 175);
  EXPECT_EQ(picture.image.at<std::uint8_t>(10, 600), 200);
  EXPECT_EQ(cv::countNonZero(picture.shown), 700 * 400);
}

TEST(CanvasTest, NearestIsTheOneOfTheGreatestWeight) {
  Canvas canvas(Blending::kNearest, 1, 100 * kTileBytes);
  canvas.Draw({0, 0, 60, 50}, Grey({60, 50}, 100), Weights({60, 50}, 0.5F));
  canvas.Draw({0, 0, 60, 50}, Grey({60, 50}, 200), Weights({60, 50}, 0.4F));
  EXPECT_EQ(canvas.Picture().image.at<std::uint8_t>(20, 20), 100);
  canvas.Draw({0, 0, 60, 50}, Grey({60, 50}, 50), Weights({60, 50}, 0.6F));
  EXPECT_EQ(canvas.Picture().image.at<std::uint8_t>(20, 20), 50);
}

TEST(CanvasTest, IsScaledDownByHalvesWhereItWouldOutgrowItsMemory) {
  constexpr std::int64_t kMost = 9 * kTileBytes;
  Canvas canvas(Blending::kAverage, 1, kMost);
  for (int i = 0; i < 12; ++i) {
    const cv::Rect part(400 * i - 900, -37 * i, 300, 200);
    canvas.MakeRoom(part);
    const cv::Rect halved = Halved(part, canvas.halvings());
    canvas.Draw(halved, Grey(halved.size(), 10 * (i + 1)), Weights(halved.size(), 1));
    EXPECT_LE(canvas.bytes(), kMost);
  }
  EXPECT_GE(canvas.halvings(), 2);
  const MosaicPicture picture = canvas.Picture();
  EXPECT_EQ(picture.scale, std::ldexp(1.0, canvas.halvings()));
  // Each is where it was drawn, as bright as it was.
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector2d at =
        (Eigen::Vector2d(400 * i - 750, -37 * i + 100) - picture.origin) / picture.scale;
    EXPECT_EQ(picture.image.at<std::uint8_t>(cvRound(at.y()), cvRound(at.x())), 10 * (i + 1)) << i;
  }
}

// Two tiles far apart need little, and a picture of both as much as all between them.
TEST(CanvasTest, IsScaledDownWhereItsPictureWouldOutgrowItsMemory) {
  constexpr std::int64_t kMost = 100 * kTileBytes;
  Canvas canvas(Blending::kAverage, 1, kMost);
  const cv::Mat pixels(8, 8, CV_8UC1, cv::Scalar(77)), weights(8, 8, CV_32FC1, cv::Scalar(1));
  for (const int at : {0, 100'000}) {
    canvas.MakeRoom({at, at, 8, 8});
    canvas.Draw(Halved({at, at, 8, 8}, canvas.halvings()), pixels(Halved({0, 0, 8, 8}, canvas.halvings())),
                weights(Halved({0, 0, 8, 8}, canvas.halvings())));
  }
  EXPECT_GT(canvas.halvings(), 0);
  const MosaicPicture picture = canvas.Picture();
  EXPECT_LE(static_cast<std::int64_t>(picture.image.total() + picture.shown.total()), kMost);
  EXPECT_GT(picture.image.cols * picture.scale, 99'000);
}

TEST(CanvasTest, AHalvedMeanIsThatOfItsFourPixels) {
  Canvas canvas(Blending::kAverage, 1, 4 * kTileBytes);
  cv::Mat pixels(256, 256, CV_8UC1);
  cv::RNG(3).fill(pixels, cv::RNG::UNIFORM, 0, 256);
  canvas.Draw({-256, 256, 256, 256}, pixels, Weights({256, 256}, 1));
  canvas.MakeRoom({-256, 0, 768, 512});  // six tiles, of which four are to be had
  ASSERT_EQ(canvas.halvings(), 1);
  const MosaicPicture picture = canvas.Picture();
  EXPECT_EQ(picture.origin, Eigen::Vector2d(-255.5, 256.5));
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      int sum = 0;
      for (int k = 0; k < 4; ++k) sum += pixels.at<std::uint8_t>(2 * y + k / 2, 2 * x + k % 2);
      ASSERT_NEAR(picture.image.at<std::uint8_t>(y, x), sum / 4.0, 0.51);
    }
}

TEST(CanvasTest, AQuickLookIsOfEverySoManyPixels) {
  Canvas canvas(Blending::kAverage, 1, 100 * kTileBytes);
  cv::Mat pixels(300, 400, CV_8UC1);
  cv::RNG(4).fill(pixels, cv::RNG::UNIFORM, 0, 256);
  canvas.Draw({0, 0, 400, 300}, pixels, Weights({400, 300}, 1));
  const MosaicPicture quick = canvas.Picture(4);
  EXPECT_EQ(quick.image.size(), cv::Size(100, 75));
  EXPECT_EQ(quick.scale, 4);
  int compared = 0;
  for (int y = 0; y < 75; ++y)
    for (int x = 0; x < 100; ++x, ++compared) {
      const Eigen::Vector2d at = quick.origin + 4 * Eigen::Vector2d(x, y);
      ASSERT_EQ(quick.image.at<std::uint8_t>(y, x),
                pixels.at<std::uint8_t>(static_cast<int>(at.y()), static_cast<int>(at.x())));
    }
  EXPECT_EQ(compared, 7500);
}

// As a mosaic is drawn anew, a tile with each image.
TEST(DrawImageTest, TileByTileIsAllAtOnce) {
  const Pinhole camera{320, 240, 200, 200, 159.5, 119.5};
  cv::Mat image(240, 320, CV_8UC1);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(image, image, {}, 3);
  for (const Surface surface : {Surface::kPlane, Surface::kSphere}) {
    const Projection projection(camera, surface, 300);
    // On the sphere it lies on both sides of half a turn.
    const Eigen::Matrix3d M_WC =
        Eigen::AngleAxisd(surface == Surface::kPlane ? 0.2 : 3.1, Eigen::Vector3d::UnitY())
            .toRotationMatrix();
    Canvas canvas(Blending::kFeather, 1, 1'000'000'000);
    DrawImage(projection, image, M_WC, canvas, Blending::kFeather);
    const MosaicPicture whole = canvas.Picture();
    const std::vector<cv::Rect> tiles = canvas.tiles();
    EXPECT_GT(tiles.size(), 3U);
    for (const cv::Rect& tile : tiles) {
      canvas.ClearTile(tile);
      EXPECT_EQ(canvas.tiles().size(), tiles.size() - 1);
      DrawImageWithin(tile, projection, image, M_WC, canvas, Blending::kFeather);
    }
    const MosaicPicture anew = canvas.Picture();
    ASSERT_EQ(anew.image.size(), whole.image.size());
    // Maps are exact at their steps, which a tile has elsewhere: single pixels of the rim are shown or not.
    cv::Mat difference;
    cv::absdiff(anew.image, whole.image, difference);
    EXPECT_LT(cv::countNonZero(difference > 2), cv::countNonZero(whole.shown) / 500);
  }
}

}  // namespace
}  // namespace kestrel::vision
