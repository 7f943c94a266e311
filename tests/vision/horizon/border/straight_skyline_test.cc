// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/straight_skyline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "geometry/tait_bryan.h"
#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/calibration_file.h"
#include "vision/horizon/border/border_look.h"

namespace kestrel::vision {
namespace {

const Pinhole kPhotograph{480, 360, 420, 420, 239.5, 179.5};

std::string Said(const SkylineResult& r) {
  return std::holds_alternative<NoSkyline>(r) ? NameOf(std::get<NoSkyline>(r)) : "fix";
}
double ErrorDeg(const SkylineFix& fix, const Eigen::Vector3d& down_C) {
  return Degrees(std::acos(std::clamp(fix.down_C.dot(down_C), -1.0, 1.0)));
}
SkylineResult Measured(const cv::Mat& image) {
  return StraightSkyline(kPhotograph, {}, Eigen::Vector3d::UnitY(), Radians(60)).Measure(image);
}
cv::Mat Painted(const PaintedWorld& world, const TaitBryan& attitude, int seed) {
  static const SkylinePhotographer photographer(kPhotograph);
  return photographer.Paint(world, RotationFromTaitBryan(attitude) * LooksForward(), seed);
}
Eigen::Vector3d DownOf(const TaitBryan& attitude) {
  return (RotationFromTaitBryan(attitude) * LooksForward()).transpose() * Eigen::Vector3d::UnitZ();
}

// Sea to the horizon: waves that grow towards the eye, a path of glitter, and a beach before it.
cv::Mat PaintedSea(const Eigen::Vector3d& down_C, bool band, bool beach, int seed) {
  const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() - down_C.z() * down_C).normalized(),
                        right = down_C.cross(ahead);
  const Eigen::Vector3d low(170, 180, 215), high(150, 120, 105), water(105, 85, 70), sand(95, 110, 125);
  cv::Mat image(kPhotograph.height_px, kPhotograph.width_px, CV_32FC3);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector3d ray = *kPhotograph.Ray({x, y});
      const double elevation = -std::asin(ray.dot(down_C)),
                   azimuth = std::atan2(right.dot(ray), ahead.dot(ray));
      Eigen::Vector3d c = low + (high - low) * (1 - std::exp(-elevation / 0.3));
      if (elevation > 0 && band)  // of cloud, lit from below
        c.array() -= 30 * std::exp(-std::pow((elevation - 0.14 - 0.03 * azimuth) / 0.03, 2));
      if (elevation <= 0) {
        const double depression = -elevation + 1e-4, fore = 1 / depression;
        const double waves = LatticeNoise(azimuth * fore * 2.5, fore * 1.7, static_cast<std::uint32_t>(seed));
        c = water.array() + 14 * waves * std::min(1.0, 0.3 + 8 * depression);
        if (LatticeNoise(azimuth * fore * 8, fore * 9, 3) > 0.3)
          c.array() += 80 * std::exp(-std::pow((azimuth - 0.1) / 0.1, 2));
        if (beach && depression > 0.13 + 0.1 * azimuth) c = sand;
      }
      image.at<cv::Vec3f>(y, x) =
          cv::Vec3f(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]));
    }
  cv::Mat noise(image.size(), CV_32FC3), out;
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(noise, cv::RNG::NORMAL, 0, 1.5);
  cv::Mat(image + noise).convertTo(out, CV_8UC3);
  return out;
}

TEST(StraightSkyline, AHorizonAcrossAPhotographIsFoundHoweverTheCameraTilts) {
  int checked = 0;
  for (const TaitBryan& attitude :
       {TaitBryan{0.4, 0, 0}, TaitBryan{2, 0.15, -0.5}, TaitBryan{-1, -0.15, 0.8}, TaitBryan{1, 0.1, 0.2}})
    for (const double cloud : {0.0, 20.0}) {
      PaintedWorld world;
      world.cloud = cloud;
      const auto result = Measured(Painted(world, attitude, ++checked));
      ASSERT_EQ(Said(result), "fix") << checked;
      EXPECT_LT(ErrorDeg(std::get<SkylineFix>(result), DownOf(attitude)), 0.5) << checked;
    }
  EXPECT_EQ(checked, 8);
}

TEST(StraightSkyline, ASeaIsFoundByItsHorizonNotByItsBeachOrABandOfCloud) {
  int checked = 0, found = 0;
  for (const bool band : {false, true})
    for (const bool beach : {false, true})
      for (const double roll : {-0.2, 0.02}) {
        const Eigen::Vector3d down(std::sin(roll), std::cos(roll), 0.03);
        cv::Mat image = PaintedSea(down.normalized(), band, beach, 11 + checked);
        if (checked % 2) {
          cv::Mat grey;
          cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
          cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
        }
        const auto result = Measured(image);
        if (const auto* fix = std::get_if<SkylineFix>(&result)) {
          EXPECT_LT(ErrorDeg(*fix, down.normalized()), 0.7) << checked;
          ++found;
        }
        ++checked;
      }
  EXPECT_GE(found, 6);
}

TEST(StraightSkyline, TheHorizonIsWhereTheSkyEndsNotTheDarkEdgeOfTheWoodsBelowTheHaze) {
  // Three layers: sky, ground that the haze has paled, woods.
  const TaitBryan attitude{0.3, 0, 0.3}, lower{0.3, 0.04, 0.3};
  PaintedWorld hazy, woods;
  hazy.ground = hazy.ground_far = {180, 172, 163};
  hazy.ground_rough = 8;
  woods.ground = woods.ground_far = {40, 60, 50};
  woods.haze_m = 1e6;
  cv::Mat image = Painted(hazy, attitude, 5);
  const cv::Mat near = Painted(woods, lower, 6);
  const Eigen::Vector3d down = DownOf(lower);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (kPhotograph.Ray({x, y})->dot(down) > 0) image.at<cv::Vec3b>(y, x) = near.at<cv::Vec3b>(y, x);
  // From the edge of the woods, the place where the sky ends lies higher.
  const PlaneView plane(kPhotograph, {});
  const auto top = LookAtBorder(plane, image, plane.BorderOf(down), true),
             edge = LookAtBorder(plane, image, plane.BorderOf(down), false);
  ASSERT_TRUE(top && edge);
  const auto off_deg = [&](const BorderLook& look, const TaitBryan& from) {
    return Degrees(std::acos(std::min(1.0, plane.DownOf(look.line, 0).dot(DownOf(from)))));
  };
  EXPECT_LT(off_deg(*top, attitude), 1);
  EXPECT_LT(off_deg(*edge, lower), 0.5);
  const auto result = Measured(image);
  ASSERT_EQ(Said(result), "fix");
  EXPECT_LT(ErrorDeg(std::get<SkylineFix>(result), DownOf(attitude)), 1);
}

TEST(StraightSkyline, APhotographWithoutAHorizonIsRefused) {
  cv::Mat even(360, 480, CV_8UC3, cv::Scalar(120, 110, 100)), noise(360, 480, CV_8UC3);
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0, 3);
  EXPECT_NE(Said(Measured(even + noise)), "fix");
  PaintedWorld cloudy;
  cloudy.cloud = 25;
  for (const double pitch : {1.3, -1.3}) EXPECT_NE(Said(Measured(Painted(cloudy, {0, pitch, 0}, 4))), "fix");
  cv::Mat checks(360, 480, CV_8UC3);
  for (int y = 0; y < 360; ++y)
    for (int x = 0; x < 480; ++x)
      checks.at<cv::Vec3b>(y, x) = (x / 40 + y / 40) % 2 ? cv::Vec3b(230, 230, 230) : cv::Vec3b(30, 30, 30);
  EXPECT_NE(Said(Measured(checks)), "fix");
}

TEST(StraightSkyline, UpsideDownIsSaid) {
  cv::Mat turned;
  cv::rotate(Painted({}, {0.4, 0, 0.1}, 2), turned, cv::ROTATE_180);
  EXPECT_EQ(Said(Measured(turned)), "upside_down");
}

TEST(StraightSkyline, SuitsLensesThatLookOneWay) {
  Mistakes mistakes;
  const auto loaded = [&](const char* name) {
    return LoadCamera(std::string(KESTREL_SOURCE_DIR) + "/models/cameras/" + name + ".yaml", mistakes);
  };
  EXPECT_TRUE(StraightSkyline::Suits(kPhotograph));
  EXPECT_TRUE(StraightSkyline::Suits(loaded("thesis_2_8mm")));
  EXPECT_FALSE(StraightSkyline::Suits(loaded("fisheye")));
  EXPECT_FALSE(StraightSkyline::Suits(loaded("hyperbolic_mirror")));
  mistakes.ThrowIfAny();
}

TEST(PlaneView, ALineAndItsDownAreOneThingAndADipTiltsItByItself) {
  const PlaneView plane(
      BrownConrady{.width_px = 640, .height_px = 480, .fx = 400, .fy = 410, .cx = 300, .cy = 250, .k1 = -0.2},
      {});
  const Eigen::Vector3d down = Eigen::Vector3d(0.3, 0.9, -0.2).normalized();
  const SkyBorder line = plane.BorderOf(down);
  EXPECT_LT((plane.DownOf(line, 0) - down).norm(), 1e-12);
  // Rays on the line are level; the one in the middle lies lower by the dip.
  const Eigen::Vector2d foot = line.offset * line.normal, along(-line.normal.y(), line.normal.x());
  EXPECT_NEAR(plane.RayOf(foot).dot(down), 0, 1e-12);
  EXPECT_NEAR(plane.RayOf(foot + 77 * along).dot(down), 0, 1e-12);
  EXPECT_LT(plane.RayOf(foot + 9 * line.normal).dot(down), 0);  // above: sky
  EXPECT_NEAR(std::acos(plane.DownOf(line, 0.02).dot(down)), 0.02, 1e-9);
}

TEST(PlaneView, StraightensWhatALensBends) {
  // A step between two grounds that lies on a plane through the eye.
  const CameraModel bent =
      BrownConrady{.width_px = 640, .height_px = 480, .fx = 400, .fy = 400, .cx = 320, .cy = 240, .k1 = -0.1};
  const Eigen::Vector3d down = Eigen::Vector3d(0.2, 1, -0.25).normalized();
  cv::Mat image(480, 640, CV_8UC3);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const auto ray = Ray(bent, {x, y});
      image.at<cv::Vec3b>(y, x) =
          ray && ray->dot(down) > 0 ? cv::Vec3b(20, 20, 20) : cv::Vec3b(220, 220, 220);
    }
  const PlaneView plane(bent, {});
  const cv::Mat view = plane.Of(image);
  const SkyBorder line = plane.BorderOf(down);
  int checked = 0;
  for (int y = 0; y < view.rows; ++y)
    for (int x = 0; x < view.cols; ++x) {
      const double above = line.normal.dot(Eigen::Vector2d(x, y)) - line.offset;
      if (!plane.shown().at<uchar>(y, x) || std::abs(above) < 3) continue;
      ASSERT_EQ(view.at<cv::Vec3b>(y, x)[0] > 128, above > 0) << x << " " << y;
      ++checked;
    }
  EXPECT_GT(checked, 100000);
}

}  // namespace
}  // namespace kestrel::vision
