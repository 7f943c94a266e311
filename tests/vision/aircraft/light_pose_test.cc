// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/light_pose.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "geometry/tait_bryan.h"
#include "tests/vision/aircraft/light_photographer.h"
#include "vision/aircraft/ground_camera.h"

namespace kestrel::vision {
namespace {

const Pinhole kCamera{640, 480, 1600, 1600, 319.5, 239.5};
const AircraftLights kLights;

// A mast that looks level along x of T, and an aircraft before it with this attitude in T.
struct Scene {
  Pose X_TC, X_TB;
  Pose X_CB() const { return X_TC.Inverse() * X_TB; }
  Eigen::Vector3d down_C() const { return X_TC.R.conjugate() * Eigen::Vector3d::UnitZ(); }
};
Scene SceneOf(double yaw_deg, double pitch_deg, double roll_deg, const Eigen::Vector3d& p_TB = {0, 0.5, -2}) {
  return {CameraPose(MastPose({.position_m = {-15, 0, 2}}), {}),
          {Eigen::Quaterniond(RotationFromTaitBryan(
               {.yaw = Radians(yaw_deg), .pitch = Radians(pitch_deg), .roll = Radians(roll_deg)})),
           p_TB}};
}

std::optional<LightPose> Found(const Scene& scene, const ExpectedAircraft& expected, unsigned seed,
                               const std::vector<bool>& hidden = {}) {
  const cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), seed, hidden);
  const auto spots = FindLights(image, {0, 0, image.cols, image.rows}, {kLights.colour_1, kLights.colour_2});
  return PoseFromLights(spots, kLights, kCamera, expected, scene.down_C());
}

// Level, and turned anyhow.
ExpectedAircraft Unknown(const Scene& scene) {
  ExpectedAircraft expected;
  expected.R_CB = scene.X_TC.R.conjugate();
  return expected;
}

TEST(LightDetector, MeasuresTheCentreOfEachLightToATenthOfAPixel) {
  const Scene scene = SceneOf(20, 3, -2);
  const cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), 1);
  const auto spots = FindLights(image, {0, 0, image.cols, image.rows}, {kLights.colour_1, kLights.colour_2});
  ASSERT_EQ(spots.size(), 5u);
  for (const AircraftLight& light : kLights.lights) {
    const Eigen::Vector2d uv = *Project(kCamera, scene.X_CB() * light.position_m);
    double nearest = 1e9;
    for (const LightSpot& spot : spots)
      if (spot.colour == light.colour) nearest = std::min(nearest, (spot.centre - uv).norm());
    EXPECT_LT(nearest, 0.1);
  }
}

TEST(LightDetector, LeavesOutWhatTheBorderOfThePartCuts) {
  const Scene scene = SceneOf(45, 0, 0);
  const cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), 1);
  const Eigen::Vector2d front = *Project(kCamera, scene.X_CB() * kLights.lights[0].position_m);
  const cv::Rect part(static_cast<int>(std::lround(front.x())), 0, 200, image.rows);
  for (const LightSpot& spot : FindLights(image, part, {kLights.colour_1, kLights.colour_2}))
    EXPECT_GT((spot.centre - front).norm(), 3);
}

TEST(LightPose, IsFoundWhateverWayTheAircraftIsTurned) {
  for (int yaw = -180; yaw < 180; yaw += 15) {
    const Scene scene = SceneOf(yaw, 4, -3);
    const auto pose = Found(scene, Unknown(scene), 3);
    ASSERT_TRUE(pose) << yaw;
    const Pose X_TB = scene.X_TC * pose->X_CB;
    EXPECT_LT((X_TB.p - scene.X_TB.p).tail<2>().norm(), 0.01) << yaw;  // across the line of sight
    EXPECT_LT(std::abs(X_TB.p.x() - scene.X_TB.p.x()), 0.2) << yaw;    // along it
    EXPECT_LT(std::abs(WrapAngle(YawOf(X_TB.R) - Radians(yaw))), Radians(3)) << yaw;
  }
}

TEST(LightPose, AgreesWithOpenCvsPnpOfTheSameSpots) {
  const Scene scene = SceneOf(30, 2, 5);
  const auto pose = Found(scene, Unknown(scene), 5);
  ASSERT_TRUE(pose);
  const cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), 5);
  const auto spots = FindLights(image, {0, 0, image.cols, image.rows}, {kLights.colour_1, kLights.colour_2});
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const AircraftLight& light : kLights.lights) {
    const Eigen::Vector2d uv = *Project(kCamera, scene.X_CB() * light.position_m);
    for (const LightSpot& spot : spots)
      if (spot.colour == light.colour && (spot.centre - uv).norm() < 2) {
        points.emplace_back(light.position_m.x(), light.position_m.y(), light.position_m.z());
        pixels.emplace_back(spot.centre.x(), spot.centre.y());
      }
  }
  const cv::Matx33d K(1600, 0, 319.5, 0, 1600, 239.5, 0, 0, 1);
  const Eigen::Vector3d p = scene.X_CB().p, turn = LogRotation(scene.X_CB().R);
  cv::Vec3d rotation(turn.x(), turn.y(), turn.z()), t(p.x(), p.y(), p.z());
  ASSERT_TRUE(cv::solvePnP(points, pixels, K, {}, rotation, t, true, cv::SOLVEPNP_ITERATIVE));
  // Ours also knows the tilt to some degrees, which moves the range by less than its sigma.
  EXPECT_NEAR(pose->X_CB.p.z(), t[2], std::sqrt(pose->covariance(2, 2)));
  EXPECT_NEAR(pose->X_CB.p.x(), t[0], 0.005);
  EXPECT_NEAR(pose->X_CB.p.y(), t[1], 0.005);
}

TEST(LightPose, TellsItsOwnErrorByItsCovariance) {
  double squared = 0;
  constexpr int kTrials = 40;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  LightPoseOptions options;
  for (int i = 0; i < kTrials; ++i) {
    const Scene scene =
        SceneOf(180 * any(random), 3 * any(random), 3 * any(random), {any(random), any(random), -2});
    std::vector<LightSpot> spots;
    std::normal_distribution<double> normal(0, options.spot_sigma_px);
    for (const AircraftLight& light : kLights.lights)
      spots.push_back({*Project(kCamera, scene.X_CB() * light.position_m) +
                           Eigen::Vector2d(normal(random), normal(random)),
                       32, light.colour});
    ExpectedAircraft expected{.R_CB = scene.X_CB().R, .yaw_sigma = Radians(8), .p_CB = scene.X_CB().p};
    const auto pose = PoseFromLights(spots, kLights, kCamera, expected, scene.down_C(), options);
    ASSERT_TRUE(pose);
    const Eigen::Vector3d off = pose->X_CB.p - scene.X_CB().p;
    squared += off.dot(pose->covariance.topLeftCorner<3, 3>().inverse() * off);
  }
  EXPECT_NEAR(squared / kTrials, 3, 1.2);
}

TEST(LightPose, StandsOneLightThatIsHiddenAndSpotsThatAreNone) {
  const Scene scene = SceneOf(10, 0, 0);
  const ExpectedAircraft expected{.R_CB = scene.X_CB().R, .yaw_sigma = Radians(8), .p_CB = scene.X_CB().p};
  for (std::size_t hidden = 0; hidden < 5; ++hidden) {
    std::vector<bool> is(5, false);
    is[hidden] = true;
    cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), 1, is);
    image(cv::Rect(100, 100, 7, 7)).setTo(cv::Scalar(234, 8, 255));
    image(cv::Rect(400, 300, 6, 6)).setTo(cv::Scalar(106, 255, 8));
    const auto spots =
        FindLights(image, {0, 0, image.cols, image.rows}, {kLights.colour_1, kLights.colour_2});
    const auto pose = PoseFromLights(spots, kLights, kCamera, expected, scene.down_C());
    ASSERT_TRUE(pose) << hidden;
    EXPECT_EQ(pose->lights, 4);
    EXPECT_LT((pose->X_CB.p - scene.X_CB().p).norm(), 0.3) << hidden;
  }
}

TEST(LightPose, LeavesOutALightThatIsPartlyHiddenAsItsSpotIsBesideIt) {
  const Scene scene = SceneOf(20, 0, 0);
  const ExpectedAircraft expected{.R_CB = scene.X_CB().R, .yaw_sigma = Radians(8), .p_CB = scene.X_CB().p};
  cv::Mat image = PhotographLights(kCamera, kLights, scene.X_CB(), 1);
  const Eigen::Vector2d front = *Project(kCamera, scene.X_CB() * kLights.lights[0].position_m);
  const cv::Point corner(static_cast<int>(std::lround(front.x())) - 8,
                         static_cast<int>(std::lround(front.y())));
  image(cv::Rect(corner, cv::Size(16, 16))).setTo(cv::Scalar(60, 60, 60));
  const auto spots = FindLights(image, {0, 0, image.cols, image.rows}, {kLights.colour_1, kLights.colour_2});
  const auto pose = PoseFromLights(spots, kLights, kCamera, expected, scene.down_C());
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->lights, 4);
  EXPECT_LT((pose->X_CB.p - scene.X_CB().p).norm(), 0.15);
}

TEST(LightPose, IsNotFoundWhereNothingIs) {
  const Scene scene = SceneOf(0, 0, 0);
  EXPECT_FALSE(Found(scene, Unknown(scene), 1, std::vector<bool>(5, true)));
  // Three lights are too few of an aircraft that may be anywhere.
  EXPECT_FALSE(Found(scene, Unknown(scene), 1, {true, true, false, false, false}));
}

TEST(GroundCamera, LooksAtAPointSoThatItIsInTheMiddleOfTheImage) {
  const Pose X_TG = MastPose({.position_m = {-10, 4, 3}, .yaw_deg = 25, .pitch_deg = 5, .roll_deg = 2});
  const Eigen::Vector3d p_T(2, -1, -5);
  const Pose X_TC = CameraPose(X_TG, LookAt(X_TG, p_T, {}));
  const Eigen::Vector3d p_C = X_TC.Inverse() * p_T;
  EXPECT_LT(p_C.head<2>().norm(), 1e-9);
  EXPECT_GT(p_C.z(), 0);
  // At rest, level and unturned it looks along x with its bottom down.
  const Pose at_rest = CameraPose(MastPose({.position_m = {0, 0, 2}}), {});
  EXPECT_TRUE((at_rest.R * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE((at_rest.R * Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d::UnitZ()));
}

}  // namespace
}  // namespace kestrel::vision
