// SPDX-License-Identifier: Apache-2.0
#include "vision/target/contrast_detector.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "geometry/pose.h"
#include "tests/vision/target/contrast_photographer.h"

namespace kestrel::vision {
namespace {

constexpr double kDownSigma = Radians(1);

const SkylinePhotographer& Photographer() {
  static const SkylinePhotographer photographer(ForwardFisheye());
  return photographer;
}
const ContrastDetector& Detector() {
  static const ContrastDetector detector(ForwardFisheye(), {}, {});
  return detector;
}
Eigen::Vector3d DownOf(const Eigen::Matrix3d& R_NC) { return R_NC.transpose() * Eigen::Vector3d::UnitZ(); }
Eigen::Vector3d Towards(double azimuth_deg, double elevation_deg) {
  const double a = Radians(azimuth_deg), e = Radians(elevation_deg);
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), -std::sin(e)};
}
// The attitude errs by a degree.
SkySearch Look(const cv::Mat& image, const Eigen::Matrix3d& R_NC) {
  return Detector().Search(image, ExpRotation({Radians(0.7), Radians(-0.7), 0}) * DownOf(R_NC), kDownSigma);
}

TEST(ContrastDetector, BallsAreMeasuredToAFractionOfAPixel) {
  const CameraModel camera = ForwardFisheye();
  const double rad_per_px = 1 / 251.1;
  int checked = 0;
  for (const double diameter_px : {3.0, 5.0, 9.0, 16.0, 30.0, 50.0})
    for (const double azimuth_deg : {-48.0, 0.3, 33.0}) {
      const Eigen::Matrix3d R_NC = RotationFromTaitBryan({0, Radians(4), Radians(2)}) * LooksForward();
      static const cv::Mat empty = Photographer().Paint({}, R_NC, 0);
      cv::Mat image = empty.clone();
      const FlyingBall ball{Towards(azimuth_deg, 21), diameter_px / 2 * rad_per_px};
      PaintFlyingBalls(image, camera, R_NC, {ball});
      const SkySearch search = Look(image, R_NC);
      ASSERT_EQ(search.state, SkySearchState::kSearched);
      ASSERT_EQ(search.detections.size(), 1u) << diameter_px << " px at " << azimuth_deg;
      const ContrastDetection& seen = search.detections[0];
      const Eigen::Vector3d axis = R_NC.transpose() * ball.direction_N.normalized();
      const double off = std::acos(std::min(1.0, seen.cone.axis.dot(axis)));
      EXPECT_LT(off, 0.12 * rad_per_px) << diameter_px << " px at " << azimuth_deg;
      EXPECT_LT(off, 4 * seen.axis_sigma);
      EXPECT_NEAR(seen.cone.half_angle / ball.half_angle, 1, diameter_px < 4 ? 0.12 : 0.04) << diameter_px;
      EXPECT_LT((seen.centre_px - *Project(camera, axis)).norm(), 0.15 + 0.01 * diameter_px);
      EXPECT_LT(seen.contrast, -50);
      ++checked;
    }
  EXPECT_EQ(checked, 18);
}

TEST(ContrastDetector, SeesBrightOnesAndRedOnesAndGreyImages) {
  const CameraModel camera = ForwardFisheye();
  const Eigen::Matrix3d R_NC = LooksForward();
  cv::Mat image = Photographer().Paint({}, R_NC, 5);
  PaintFlyingBalls(image, camera, R_NC,
                   {{Towards(-30, 30), 0.012, {250, 250, 250}}, {Towards(20, 15), 0.01, {30, 30, 190}}});
  EXPECT_EQ(Look(image, R_NC).detections.size(), 2u);
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const SkySearch search = Look(grey, R_NC);
  ASSERT_EQ(search.detections.size(), 2u);
  int brighter = 0;
  for (const ContrastDetection& d : search.detections) brighter += d.contrast > 0;
  EXPECT_EQ(brighter, 1);
}

TEST(ContrastDetector, EmptySkiesOfFourWeathersHoldNothing) {
  int checked = 0;
  for (const PaintedWorld& world : FourSkies())
    for (const double heading : {0.0, 0.4, 2.2}) {
      const Eigen::Matrix3d R_NC = RotationFromTaitBryan({heading, 0.05, 0.1}) * LooksForward();
      const SkySearch search = Look(Photographer().Paint(world, R_NC, checked), R_NC);
      EXPECT_EQ(search.state, SkySearchState::kSearched);
      EXPECT_TRUE(search.detections.empty())
          << "sky " << checked / 3 << ", heading " << heading << ", at "
          << (search.detections.empty() ? Eigen::Vector2d(0, 0) : search.detections[0].centre_px).transpose();
      ++checked;
    }
  EXPECT_EQ(checked, 12);
}

TEST(ContrastDetector, TreesHillsAndTheSunAreRefusedAndABallBetweenThemIsFound) {
  const CameraModel camera = ForwardFisheye();
  PaintedWorld world;
  world.noise = 2;
  world.sun_N = Towards(25, 30);
  // Hills, and trees as narrow as a degree and up to 9 degrees high.
  world.hills = [](double azimuth) {
    const double tree = std::fmod(azimuth + 10, 0.21);
    return Radians(1.5) * (1 + std::sin(3 * azimuth)) +
           (tree < 0.035 ? Radians(7) * std::sqrt(std::max(0.0, 1 - std::pow(tree / 0.0175 - 1, 2))) : 0);
  };
  const Eigen::Matrix3d R_NC = LooksForward();
  cv::Mat image = Photographer().Paint(world, R_NC, 1);
  EXPECT_TRUE(Look(image, R_NC).detections.empty());
  const FlyingBall ball{Towards(-20, 14), 0.01};
  PaintFlyingBalls(image, camera, R_NC, {ball});
  const SkySearch search = Look(image, R_NC);
  ASSERT_EQ(search.detections.size(), 1u);
  EXPECT_GT(search.detections[0].cone.axis.dot(R_NC.transpose() * ball.direction_N), std::cos(0.002));
}

TEST(ContrastDetector, BelowTheHorizonAndOnTheAircraftItselfNothingIsLookedFor) {
  const CameraModel camera = ForwardFisheye();
  const Eigen::Matrix3d R_NC = LooksForward();
  cv::Mat image = Photographer().Paint({}, R_NC, 2);
  PaintFlyingBalls(image, camera, R_NC, {{Towards(10, -12), 0.02, {10, 10, 10}}});
  EXPECT_TRUE(Look(image, R_NC).detections.empty());
  // A rotor's hub before the sky.
  const cv::Point hub(200, 90);
  cv::circle(image, hub, 9, {20, 20, 20}, cv::FILLED);
  EXPECT_EQ(Look(image, R_NC).detections.size(), 1u);
  cv::Mat forbidden = cv::Mat::zeros(image.size(), CV_8UC1);
  cv::circle(forbidden, hub, 11, 255, cv::FILLED);
  EXPECT_TRUE(
      ContrastDetector(camera, forbidden, {}).Search(image, DownOf(R_NC), kDownSigma).detections.empty());
}

TEST(ContrastDetector, BadImagesAreNamed) {
  const Eigen::Vector3d down(0, 1, 0);
  const auto state = [&](const cv::Mat& image) { return Detector().Search(image, down, kDownSigma).state; };
  const cv::Size size(640, 480);
  EXPECT_EQ(state({}), SkySearchState::kBadImage);
  EXPECT_EQ(state(cv::Mat(480, 320, CV_8UC3)), SkySearchState::kBadImage);
  EXPECT_EQ(state(cv::Mat(size, CV_32FC3)), SkySearchState::kBadImage);
  EXPECT_EQ(state(cv::Mat(size, CV_8UC3, cv::Scalar::all(2))), SkySearchState::kTooDark);
  EXPECT_EQ(state(cv::Mat(size, CV_8UC3, cv::Scalar::all(255))), SkySearchState::kWhiteOut);
  EXPECT_EQ(state(cv::Mat(size, CV_8UC1, cv::Scalar::all(255))), SkySearchState::kWhiteOut);
  const cv::Mat sky(size, CV_8UC3, cv::Scalar(200, 150, 120));
  EXPECT_EQ(state(sky), SkySearchState::kSearched);
  EXPECT_EQ(Detector().Search(sky, {0, 2, 0}, kDownSigma).state, SkySearchState::kBadImage);
  EXPECT_EQ(Detector().Search(sky, {0, 0, 1}, kDownSigma).state, SkySearchState::kNoSky);  // looks down
}

}  // namespace
}  // namespace kestrel::vision
