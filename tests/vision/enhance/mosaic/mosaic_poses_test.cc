// SPDX-License-Identifier: Apache-2.0
// What the poses of a flight do for its mosaic, and lenses that see far to the side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "tests/vision/enhance/mosaic/drawn_ground.h"
#include "vision/camera/kannala_brandt.h"
#include "vision/enhance/mosaic/mosaic.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The farthest that a middle of an image is from where it was taken, m.
double FarthestOff_m(const Mosaic& mosaic, const std::vector<Pose>& poses) {
  const auto ground = mosaic.GroundFromSurface();
  double farthest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector2d middle(159.5, 119.5);
    const auto place = mosaic.PlaceOf(static_cast<int>(i), middle);
    EXPECT_TRUE(place) << i;
    if (!place) continue;
    farthest = std::max(
        farthest,
        (Transfer(DrawnGround::GroundFromImage(poses[i]), middle) - Transfer(*ground, *place)).norm());
  }
  return farthest;
}

// Ground that is the same every metre, as grass of a simulator is, and a way that turns a corner: it does not go on as
// it was, by more than half a metre.
TEST(MosaicPosesTest, GroundThatRepeatsIsFollowedByWhatPosesSayOfTheMotion) {
  constexpr int kPeriod_px = static_cast<int>(1 / DrawnGround::kPixel_m);
  DrawnGround ground(5);
  const cv::Mat once = ground.picture(cv::Rect(0, 0, kPeriod_px, kPeriod_px)).clone();
  cv::repeat(once, ground.picture.rows / kPeriod_px, ground.picture.cols / kPeriod_px, ground.picture);
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i)
    poses.push_back(DrawnGround::Above(-2 + 0.65 * std::min(i, 6), 0.65 * std::max(i - 6, 0), 10));
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.pose_sigma_m = 1;
  Mosaic mosaic(options);
  // All but the first are off by some centimetres.
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Pose known = poses[i];
    if (i > 0) known.p += Vector3d(0.02 * std::sin(3.0 * static_cast<double>(i)), 0.02, 0);
    EXPECT_TRUE(IsPlaced(mosaic.Add(ground.Draw(poses[i]), static_cast<double>(i), known).state)) << i;
  }
  mosaic.Adjust();
  EXPECT_LT(FarthestOff_m(mosaic, poses), 0.1);
}

TEST(MosaicPosesTest, TheFirstImageThatHasAPoseLaysOutThoseBeforeIt) {
  const DrawnGround ground(6);
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.pose_sigma_m = 0.02, options.pose_sigma_deg = 0.1;
  Mosaic mosaic(options);
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(DrawnGround::Above(-3 + 0.5 * i, 1, 10, 20));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto known = i < 3 ? std::nullopt : std::optional(poses[i]);
    EXPECT_TRUE(IsPlaced(mosaic.Add(ground.Draw(poses[i]), static_cast<double>(i), known).state)) << i;
    EXPECT_EQ(mosaic.GroundFromSurface().has_value(), i >= 3) << i;
  }
  mosaic.Adjust();
  EXPECT_LT(FarthestOff_m(mosaic, poses), 0.05);
}

TEST(MosaicPosesTest, AnImageThatSeesTheGroundFromItsSideBeginsNoMosaic) {
  const DrawnGround ground(6);
  MosaicOptions options;
  options.camera = kGroundCamera;
  Mosaic mosaic(options);
  const Pose down = DrawnGround::Above(0, 0, 10);
  for (const double pitch_deg : {75.0, 80.0, 90.0})
    EXPECT_EQ(mosaic.Add(ground.Draw(down), 0, DrawnGround::Above(0, 0, 10, 0, pitch_deg)).state,
              MosaicState::kOblique)
        << pitch_deg;
  EXPECT_EQ(mosaic.keyframes(), 0);
  EXPECT_TRUE(mosaic.CanvasSize().empty());
  EXPECT_EQ(mosaic.Add(ground.Draw(down), 1, down).state, MosaicState::kFirst);
}

// Poses may be wild where images agree with none: what is drawn is bounded all the same.
TEST(MosaicPosesTest, APoseFarAwayDoesNotOutgrowTheMemory) {
  const DrawnGround ground(6), other(8);
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.most_bytes = 20'000'000;
  Mosaic mosaic(options);
  const Pose here = DrawnGround::Above(0, 0, 10), far = DrawnGround::Above(9000, 9000, 10),
             beyond = DrawnGround::Above(90000, 0, 10);
  mosaic.Add(ground.Draw(here), 0, here);
  EXPECT_EQ(mosaic.Add(other.Draw(here), 1, far).state, MosaicState::kByPose);
  EXPECT_EQ(mosaic.Add(other.Draw(here), 2, beyond).state, MosaicState::kOblique);
  EXPECT_LT(mosaic.CanvasSize().area(), options.most_bytes);
}

// Two places a period apart look alike, and so do features: what poses cannot be is no loop.
TEST(MosaicPosesTest, WhatPosesRuleOutIsNotBelieved) {
  const DrawnGround ground(6);
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.pose_sigma_m = 0.05, options.pose_sigma_deg = 0.1;
  Mosaic mosaic(options);
  const Pose here = DrawnGround::Above(0, 0, 10);
  mosaic.Add(ground.Draw(here), 0, here);
  // The same picture once more, and its pose says that it is 3 m on.
  const MosaicStep step = mosaic.Add(ground.Draw(here), 1, DrawnGround::Above(3, 0, 10));
  EXPECT_EQ(step.state, MosaicState::kByPose);
}

// A camera that looks obliquely at flat ground, turns and strays by decimetres while it does.
double RotationError_deg(bool with_poses) {
  const DrawnGround ground;
  std::vector<Pose> poses;
  for (int i = 0; i < 14; ++i)
    poses.push_back(DrawnGround::Above(0.15 * std::sin(0.4 * i), 0.02 * i, 12, 4.0 * i, 35));
  MosaicOptions options;
  options.camera = kGroundCamera;
  options.model = MosaicModel::kRotation;
  options.surface = Surface::kSphere;
  options.pose_sigma_deg = 10;
  Mosaic mosaic(options);
  for (std::size_t i = 0; i < poses.size(); ++i)
    mosaic.Add(ground.Draw(poses[i]), static_cast<double>(i),
               with_poses ? std::optional(poses[i]) : std::nullopt);
  mosaic.Adjust();
  const auto R_WC0 = mosaic.M_WC(0), R_WC1 = mosaic.M_WC(mosaic.images() - 1);
  EXPECT_TRUE(R_WC0 && R_WC1);
  if (!R_WC0 || !R_WC1) return 0;
  const Matrix3d is = poses.front().R.toRotationMatrix().transpose() * poses.back().R.toRotationMatrix();
  const Matrix3d has = R_WC0->transpose() * *R_WC1;
  return Degrees(LogRotation(Eigen::Quaterniond(Matrix3d(is.transpose() * has))).norm());
}

TEST(MosaicPosesTest, ThePanoramaOfACameraThatStraysOverGroundIsTrue) {
  const double without = RotationError_deg(false), with = RotationError_deg(true);
  EXPECT_GT(without, 0.3);
  EXPECT_LT(with, 0.05);
}

// A fisheye sees beyond what a pinhole can, and its straight lines are bent.
TEST(FisheyeMosaicTest, ImagesLieWhereTheyWereTaken) {
  const DrawnGround ground(1, {4000, 4000});
  const KannalaBrandt camera{320, 240, 180, 180, 159.5, 119.5, -0.02, 0.003};
  const auto ground_of = [&](const Pose& X_NC, const Vector2d& uv) -> std::optional<Vector2d> {
    const auto ray = camera.Ray(uv);
    if (!ray) return std::nullopt;
    const Vector3d ray_N = X_NC.R * *ray;
    if (ray_N.z() <= 0) return std::nullopt;
    return Vector2d((X_NC.p - X_NC.p.z() / ray_N.z() * ray_N).head<2>());
  };
  const auto draw = [&](const Pose& X_NC) {
    cv::Mat u(240, 320, CV_32F), v(240, 320, CV_32F), image;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x) {
        const Vector2d at = ground_of(X_NC, {x, y}).value_or(Vector2d::Zero());
        u.at<float>(y, x) = static_cast<float>(at.y() / DrawnGround::kPixel_m + ground.picture.cols / 2.0);
        v.at<float>(y, x) = static_cast<float>(-at.x() / DrawnGround::kPixel_m + ground.picture.rows / 2.0);
      }
    cv::remap(ground.picture, image, u, v, cv::INTER_LINEAR, cv::BORDER_REFLECT);
    return image;
  };
  MosaicOptions options;
  options.camera = camera;
  Mosaic mosaic(options);
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) {
    poses.push_back(
        DrawnGround::Above(-4 + 0.8 * i, 0.3 * std::sin(i), 5, 3 * std::sin(0.7 * i), 2 * std::sin(i)));
    EXPECT_TRUE(IsPlaced(mosaic.Add(draw(poses.back()), i).state)) << i;
  }
  mosaic.Adjust();
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (const Vector2d& uv : {Vector2d(20, 20), Vector2d(300, 20), Vector2d(300, 220), Vector2d(20, 220)})
      pairs.push_back({*mosaic.PlaceOf(static_cast<int>(i), uv), *ground_of(poses[i], uv)});
  const auto H = FitHomography(pairs);
  ASSERT_TRUE(H);
  double squares = 0;
  for (const PointPair& pair : pairs) squares += (Transfer(*H, pair.from) - pair.to).squaredNorm();
  constexpr double kPixelBelow_m = 5.0 / 180;  // of the middle; in these corners it is four times as long
  EXPECT_LT(std::sqrt(squares / static_cast<double>(pairs.size())), kPixelBelow_m);
}

}  // namespace
}  // namespace kestrel::vision
