// SPDX-License-Identifier: Apache-2.0
#include "vision/target/balloon_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include "tests/vision/target/balloon_photographer.h"
#include "vision/target/balloon_tracker.h"

namespace kestrel::vision {
namespace {

const Pinhole kPinhole{320, 240, 250, 250, 159.5, 119.5};
// Some 150 degrees across.
const KannalaBrandt kFisheye{320, 240, 125, 125, 159.5, 119.5, -0.02, 0.004, -0.001, 0.0001};
const DoubleSphere kSphere{320, 240, 90, 90.5, 161, 118.5, -0.2, 0.6, 1.6};
const ColourModel kRed{ColourRange{}};

struct Errors {
  FitState state = FitState::kBadImage;
  double across_px = 0, half_angle_px = 0;  // of the bearing and of the half-angle, pixels of f_px
  double squared = 0;                       // of x, y, diameter by their covariance, 3 on average
  double camshift_px = 0;                   // of CamShift's centre
  BalloonObservation seen;
};

// One look of a new tracker.
Errors Look(const CameraModel& camera, const PaintedBalls& world, double f_px, int seed = 1) {
  BalloonTracker tracker(kRed, camera, {});
  Errors e;
  e.seen = tracker.Track(PaintBalls(camera, world, seed));
  if (!e.seen.fit) return e;
  e.state = e.seen.fit->state;
  // The truth by trigonometry, not by the code under test.
  const Eigen::Vector3d p = world.balls[0].p_CT;
  const double half_angle =
      std::atan2(world.balls[0].radius, std::sqrt(p.squaredNorm() - std::pow(world.balls[0].radius, 2)));
  e.camshift_px = (e.seen.track.target->centre - *Project(camera, p)).norm();
  e.across_px = e.seen.fit->cone.axis.cross(p.normalized()).norm() * f_px;
  e.half_angle_px = (e.seen.fit->cone.half_angle - half_angle) * f_px;
  if (e.seen.features) {
    const Eigen::Vector3d truth(p.x() / p.z(), p.y() / p.z(), 2 * world.balls[0].radius / p.z());
    const Eigen::Vector3d d = e.seen.features->xyd - truth;
    e.squared = d.dot(e.seen.features->covariance.inverse() * d);
  }
  return e;
}

TEST(BalloonFitTest, FindsBearingAndHalfAngleToATenthOfAPixelThroughAnyCamera) {
  for (const auto& [camera, f_px] : {std::pair{CameraModel(kPinhole), 250.0},
                                     {CameraModel(kFisheye), 125.0},
                                     {CameraModel(kSphere), 100.0}})
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.1, 0.05, 1.2), {-0.8, 0.5, 2.5}, {1.2, -0.9, 3}}) {
      PaintedBalls world;
      world.balls[0].p_CT = p;
      const Errors e = Look(camera, world, f_px);
      ASSERT_EQ(std::string(NameOf(e.state)), "fitted") << NameOf(camera) << ' ' << p.transpose();
      EXPECT_LT(e.across_px, 0.1) << NameOf(camera) << ' ' << p.transpose();
      EXPECT_LT(std::abs(e.half_angle_px), 0.1) << NameOf(camera) << ' ' << p.transpose();
    }
}

TEST(BalloonFitTest, FarOffTheAxisOfAFisheyeTheOutlineIsNoCircleButTheConeHolds) {
  PaintedBalls world;
  world.balls[0].p_CT = {1.0, 0.15, 0.25};  // 75 degrees off, 14 degrees of half-angle
  const Errors e = Look(kSphere, world, 100);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_LT(e.across_px, 0.15);
  EXPECT_LT(std::abs(e.half_angle_px), 0.15);
  // The middle of its box is not its direction: what CamShift would take.
  const cv::Rect2d box = *OutlineBox(kSphere, e.seen.fit->cone);
  const Eigen::Vector2d middle(box.x + box.width / 2 - 0.5, box.y + box.height / 2 - 0.5);
  EXPECT_GT((middle - *kSphere.Project(world.balls[0].p_CT)).norm(), 0.5);
}

TEST(BalloonFitTest, ItsCovarianceIsThatOfItsErrors) {
  double sum = 0;
  constexpr int kLooks = 30;
  for (int i = 0; i < kLooks; ++i) {
    PaintedBalls world;
    cv::RNG rng(static_cast<std::uint64_t>(i) + 900);
    const double z = rng.uniform(1.2, 5.0);
    world.balls[0].p_CT = {z * rng.uniform(-0.4, 0.4), z * rng.uniform(-0.3, 0.3), z};
    world.noise = 4;
    const Errors e = Look(kPinhole, world, 250, i);
    ASSERT_EQ(e.state, FitState::kFitted) << i;
    sum += e.squared;
  }
  EXPECT_GT(sum / kLooks, 0.3);
  EXPECT_LT(sum / kLooks, 4.5);
}

TEST(BalloonFitTest, APoleBeforeItMovesCamShiftAndNotTheCone) {
  PaintedBalls world;
  world.balls[0].p_CT = {0.1, 0.1, 1.5};
  world.front = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    const double x = r.x() / r.z();
    if (x > -0.14 && x < 0.03) return Eigen::Vector3d(40, 60, 70);  // over a third of it
    return {};
  };
  const Errors e = Look(kPinhole, world, 250);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_GT(e.camshift_px, 5);
  EXPECT_LT(e.across_px, 0.3);
  EXPECT_LT(std::abs(e.half_angle_px), 0.3);
}

TEST(BalloonFitTest, ItsStringIsNotItsOutline) {
  PaintedBalls world;
  world.balls[0].p_CT = {0, 0.1, 2};
  world.front = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    // Of its own colour: nothing but its shape tells it.
    if (std::abs(r.x() / r.z()) < 0.006 && r.y() / r.z() > 0.17) return Eigen::Vector3d(30, 25, 215);
    return {};
  };
  const Errors e = Look(kPinhole, world, 250);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_LT(e.across_px, 0.12);
  EXPECT_LT(std::abs(e.half_angle_px), 0.12);
}

TEST(BalloonFitTest, ABumpOfItsColourOnItsRimIsAnOutlier) {
  PaintedBalls world;
  world.balls[0].p_CT = {0, 0.1, 1.5};
  // It stands out by 3 px along a fifth of the rim.
  const Eigen::Vector3d axis = world.balls[0].p_CT.normalized();
  const double half_angle = std::asin(0.25 / world.balls[0].p_CT.norm());
  world.front = [=](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    const Eigen::Vector3d side = r - r.dot(axis) * axis;
    const double out = std::atan2(side.norm(), r.dot(axis)) / half_angle;
    if (out > 0.97 && out < 1.08 && side.x() > 0.82 * side.norm()) return Eigen::Vector3d(22, 18, 160);
    return {};
  };
  const Errors e = Look(kPinhole, world, 250);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_LT(e.across_px, 0.15);
  EXPECT_LT(std::abs(e.half_angle_px), 0.15);
}

TEST(BalloonFitTest, BlurredByMotionItIsWhereItWasInTheMiddleOfTheExposure) {
  PaintedBalls world;
  world.balls[0].p_CT = {0, 0.1, 2};
  world.balls[0].step = {0.08, 0.03, 0};  // 10 px of its 62 px
  const Errors e = Look(kPinhole, world, 250);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_LT(e.across_px, 0.4);
  EXPECT_LT(std::abs(e.half_angle_px), 0.4);
}

TEST(BalloonFitTest, InDimAndColouredLightItIsTheSame) {
  PaintedBalls world;
  world.balls[0].p_CT = {0.3, -0.1, 2};
  world.brightness = 0.4;
  world.tint = {0.7, 0.9, 1};
  const Errors e = Look(kPinhole, world, 250);
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_LT(e.across_px, 0.12);
  EXPECT_LT(std::abs(e.half_angle_px), 0.12);
}

TEST(BalloonFitTest, HalfOutOfTheImageItsCentreIsStillKnown) {
  PaintedBalls world;
  world.balls[0].p_CT = {-1.23, 0, 2};  // its middle at 5 px, of a radius of 37 px
  const Errors e = Look(kPinhole, world, 250);
  EXPECT_EQ(std::string(NameOf(e.seen.track.state)), "at the edge");
  ASSERT_EQ(std::string(NameOf(e.state)), "fitted");
  EXPECT_GT(e.camshift_px, 5);
  EXPECT_LT(e.across_px, 0.5);
  EXPECT_LT(std::abs(e.half_angle_px), 0.5);
}

// Its background goes from bright to dark in pieces of the ball's size, as houses with their windows do.
TEST(BalloonFitTest, CutByTheEdgeOfTheImageItsSizeIsAsDoubtfulAsItsErrorsAre) {
  double squares = 0;
  int looks = 0;
  for (int i = 0; i < 60; ++i) {
    PaintedBalls world;
    cv::RNG rng(static_cast<std::uint64_t>(i) + 70);
    const double z = 6, left_px = rng.uniform(-0.3, 0.6);  // of its radius: where its middle is
    const double radius_px = 250 * world.balls[0].radius / z;
    world.balls[0].p_CT = {z * (left_px * radius_px - 160) / 250, z * rng.uniform(-0.3, 0.3), z};
    world.behind = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
      const bool window = LatticeNoise(40 * r.x(), 40 * r.y(), 5) > 0.1;
      return window ? Eigen::Vector3d(70, 60, 60) : Eigen::Vector3d(150, 160, 165);
    };
    const Errors e = Look(kPinhole, world, 250, i);
    if (e.state != FitState::kFitted) continue;
    ++looks;
    squares += std::pow(e.half_angle_px / (250 * e.seen.fit->half_angle_sigma), 2);
  }
  EXPECT_GT(looks, 30);
  EXPECT_GT(squares / looks, 0.1);
  EXPECT_LT(squares / looks, 1.6);
}

TEST(BalloonFitTest, TrackedInFrontOfAWallOfItsColourItKeepsTheBallWhereCamShiftTakesTheWall) {
  BalloonTracker tracker(kRed, kPinhole, {});
  ColourTracker alone(kRed, {});
  double worst_px = 0, camshift_px = 0;
  for (int k = 0; k < 12; ++k) {
    PaintedBalls world;
    world.balls[0].p_CT = {-0.6 + 0.08 * k, 0.1, 2};  // the wall's edge is at x = 0.05
    world.behind = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
      if (r.x() / r.z() > 0.05 && r.x() / r.z() < 0.3 && std::abs(r.y() / r.z()) < 0.3)
        return Eigen::Vector3d(45, 40, 130);
      return {};
    };
    const cv::Mat image = PaintBalls(kPinhole, world, k);
    const BalloonObservation seen = tracker.Track(image);
    ASSERT_TRUE(seen.cone) << k << (seen.fit ? NameOf(seen.fit->state) : NameOf(seen.track.state));
    worst_px = std::max(worst_px, seen.cone->axis.cross(world.balls[0].p_CT.normalized()).norm() * 250);
    if (const auto target = alone.Track(image).target)
      camshift_px = std::max(camshift_px, (target->centre - *kPinhole.Project(world.balls[0].p_CT)).norm());
  }
  EXPECT_LT(worst_px, 1.0);
  EXPECT_GT(camshift_px, 15);
}

TEST(BalloonTracker, ByCamShiftItsFeaturesArePixelsOverTheFocalLength) {
  BalloonTracker tracker(kRed, kPinhole, {}, BalloonMeasure::kCamShift);
  PaintedBalls world;
  world.balls[0].p_CT = {0.5, -0.3, 2};
  const BalloonObservation seen = tracker.Track(PaintBalls(kPinhole, world));
  ASSERT_TRUE(seen.track.target && seen.features && seen.cone);
  EXPECT_FALSE(seen.fit);
  const ColourTarget& target = *seen.track.target;
  EXPECT_NEAR(seen.features->xyd.x(), (target.centre.x() - 159.5) / 250, 1e-9);
  EXPECT_NEAR(seen.features->xyd.y(), (target.centre.y() - 119.5) / 250, 1e-9);
  EXPECT_NEAR(seen.features->xyd.z(), target.diameter_px / 250, 1e-9);
  EXPECT_LT(seen.cone->axis.cross(world.balls[0].p_CT.normalized()).norm() * 250, 2);
  EXPECT_NEAR(seen.cone->half_angle * world.balls[0].p_CT.norm() / world.balls[0].radius, 1, 0.1);
}

TEST(BalloonFitTest, StartedOnSomethingLargerOfItsColourItRefusesThatAndTakesTheBall) {
  PaintedBalls world;
  world.balls[0].p_CT = {0.9, 0.1, 3};
  world.behind = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    if (std::abs(r.x() / r.z() + 0.3) + std::abs(r.y() / r.z()) < 0.2) return Eigen::Vector3d(30, 25, 215);
    return {};
  };
  BalloonTracker tracker(kRed, kPinhole, {});
  const cv::Mat image = PaintBalls(kPinhole, world);
  for (int k = 0; k < 5; ++k) EXPECT_FALSE(tracker.Track(image).cone) << k;
  const BalloonObservation seen = tracker.Track(image);
  ASSERT_TRUE(seen.cone);
  EXPECT_LT(seen.cone->axis.cross(world.balls[0].p_CT.normalized()).norm() * 250, 0.2);
}

TEST(BalloonFitTest, ABoxOfItsColourIsNotRound) {
  PaintedBalls world;
  world.balls.clear();
  world.behind = [](const Eigen::Vector3d& r) -> std::optional<Eigen::Vector3d> {
    if (std::abs(r.x() / r.z()) < 0.2 && std::abs(r.y() / r.z()) < 0.2) return Eigen::Vector3d(30, 25, 215);
    return {};
  };
  const cv::Mat image = PaintBalls(kPinhole, world);
  EXPECT_EQ(std::string(NameOf(FitBalloon(image, kPinhole, kRed, {159.5, 119.5}, 110).state)),
            "too little outline");
}

TEST(BalloonFitTest, WhatCannotBeFittedIsNamed) {
  PaintedBalls world;
  const cv::Mat image = PaintBalls(kPinhole, world);
  EXPECT_EQ(FitBalloon(cv::Mat(), kPinhole, kRed, {160, 120}, 30).state, FitState::kBadImage);
  EXPECT_EQ(FitBalloon(image, kFisheye, kRed, {159.5, 119.5}, 1).state, FitState::kTooSmall);
  EXPECT_EQ(FitBalloon(image, kPinhole, kRed, {20, 20}, 30).state, FitState::kTooLittleOutline);
  Pinhole narrow = kPinhole;
  narrow.max_angle_rad = 0.3;
  EXPECT_EQ(FitBalloon(image, narrow, kRed, {20, 20}, 30).state, FitState::kOffLens);
  EXPECT_EQ(FitBalloon(image, kPinhole, kRed, {NAN, 20}, 30).state, FitState::kOffLens);
}

TEST(BalloonFitTest, TheFeaturesAreThoseOfEquation516ForASphereHoweverNear) {
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0.3), {0.3, -0.2, 0.5}, {-4, 2, 9}}) {
    const OutlineCone cone = *ConeOfSphere(p, 0.25);
    const SphereFeatures f = *FeaturesOf(cone, Eigen::Matrix4d::Zero());
    EXPECT_LT((f.xyd - Eigen::Vector3d(p.x() / p.z(), p.y() / p.z(), 0.5 / p.z())).norm(), 1e-12);
  }
  EXPECT_FALSE(ConeOfSphere({0, 0.1, 0.2}, 0.25));
  EXPECT_FALSE(FeaturesOf({{0, 0, -1}, 0.1}, Eigen::Matrix4d::Zero()));
}

TEST(BalloonFitTest, TheCovarianceOfTheFeaturesIsCarriedOverByTheirDifferences) {
  const OutlineCone cone = *ConeOfSphere({0.5, -0.3, 1.1}, 0.25);
  Eigen::Matrix4d A;
  A << 2, 0.3, 0.1, 0.2, 0, 1.5, 0.4, 0.1, 0, 0, 1, 0.3, 0, 0, 0, 0.7;
  const Eigen::Matrix4d covariance = 1e-6 * A * A.transpose();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 4; ++i) {  // the columns of a root of it, by central differences
    constexpr double kStep = 1e-4;
    const Eigen::Vector4d column = 1e-3 * A.col(i);
    const auto at = [&](double t) {
      OutlineCone c = cone;
      c.axis += t * column.head<3>(), c.half_angle += t * column(3);
      return FeaturesOf(c, Eigen::Matrix4d::Zero())->xyd;
    };
    const Eigen::Vector3d d = (at(kStep) - at(-kStep)) / (2 * kStep);
    sum += d * d.transpose();
  }
  EXPECT_LT((FeaturesOf(cone, covariance)->covariance - sum).norm(), 1e-6 * sum.norm());
}

TEST(BalloonFitTest, TheBoxOfTheOutlineHoldsThePaintedBall) {
  PaintedBalls world;
  world.balls[0].p_CT = {0.35, 0.2, 1.1};
  for (const CameraModel& camera : {CameraModel(kPinhole), CameraModel(kFisheye)}) {
    const cv::Rect2d box = *OutlineBox(camera, *ConeOfSphere(world.balls[0].p_CT, world.balls[0].radius));
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (double v = 0; v < 240; v += 0.5)
      for (double u = 0; u < 320; u += 0.5) {
        const auto ray = Ray(camera, {u, v});
        if (!ray || ray->cross(world.balls[0].p_CT).norm() > world.balls[0].radius) continue;
        left = std::min(left, u), right = std::max(right, u), top = std::min(top, v),
        bottom = std::max(bottom, v);
      }
    EXPECT_NEAR(box.x, left + 0.5, 0.5);
    EXPECT_NEAR(box.br().x, right + 0.5, 0.5);
    EXPECT_NEAR(box.y, top + 0.5, 0.5);
    EXPECT_NEAR(box.br().y, bottom + 0.5, 0.5);
  }
}

}  // namespace
}  // namespace kestrel::vision
