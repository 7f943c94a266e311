// SPDX-License-Identifier: Apache-2.0
#include "scenarios/gyro_failure/gyro_failure.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>

#include "geometry/tait_bryan.h"
#include "mission/horizon_observer.h"
#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/camera_model.h"
#include "vision/drawn_colours.h"

namespace kestrel::scenarios {
namespace {

constexpr double kFrame_s = 0.05;
constexpr double kYaw = Radians(40);  // by the autopilot's own north

mission::MissionParts Parts(const vision::CameraModel& camera) {
  mission::MissionParts parts;
  parts.camera = camera;
  parts.X_BC = {Eigen::Quaterniond(vision::LooksDown()), {0, 0, 0}};
  return parts;
}

// The mission over a painted world; the aircraft stands level in the air, whatever its autopilot believes.
class Watcher {
 public:
  explicit Watcher(const GyroFailureFlight& flight = {}) : mission_(MakeMission(flight, Parts(camera_))) {
    picture_ = vision::SkylinePhotographer(camera_).Paint({}, vision::LooksDown(), 1);
  }

  mission::Decision See(const std::optional<Eigen::Quaterniond>& own, bool dark = false) {
    t_s_ += kFrame_s;
    control::VehicleState state;
    state.t_s = t_s_;
    state.p_NB = {0, 0, -60};
    state.R_NB = HeadingRotation(kYaw);
    state.R_NB_inertial = own;
    cv::Mat image, noise(picture_.size(), CV_16SC3);
    random_.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(dark ? cv::Mat::zeros(picture_.size(), CV_8UC3) : picture_, noise, image, {}, CV_8UC3);
    return mission_->Step({image, t_s_, static_cast<std::int64_t>(t_s_ / kFrame_s)}, state);
  }
  // A sound attitude is never twice the same.
  Eigen::Quaterniond Sound(double roll_deg = 0) {  // off by a roll
    const auto jitter = [&] { return Radians(0.05) * random_.gaussian(1); };
    return Eigen::Quaterniond(
        RotationFromTaitBryan({kYaw + jitter(), jitter(), Radians(roll_deg) + jitter()}));
  }
  std::vector<mission::Caption> Captions() const { return mission_->Captions(); }
  // Pixels of the last frame, as a video has it, in the colour of what must not be.
  int Struck() const {
    cv::Mat drawn = picture_.clone(), struck;
    mission_->Draw(drawn);
    cv::inRange(drawn, vision::kLimitColour, vision::kLimitColour, struck);
    return cv::countNonZero(struck);
  }
  void LearnWhatIsNormal() {
    for (int i = 0; i < 10; ++i) {
      const mission::Decision d = See(Sound());
      ASSERT_FALSE(d.aid);
      ASSERT_EQ(d.phase, "by own attitude");
      ASSERT_EQ(d.target, "horizon");
    }
  }

 private:
  static vision::CameraModel SmallMirror() {
    vision::Unified mirror;
    mirror.width_px = 320, mirror.height_px = 240;
    mirror.fx = mirror.fy = 67, mirror.cx = 159.5, mirror.cy = 119.5;
    mirror.xi = 0.99, mirror.max_angle_rad = Radians(120);
    return mirror;
  }
  vision::CameraModel camera_ = SmallMirror();
  std::unique_ptr<mission::Mission> mission_;
  cv::Mat picture_;
  cv::RNG random_{12345};
  double t_s_ = 0;
};

TEST(GyroFailure, ASilentAttitudeIsReplacedInTheSameFrame) {
  Watcher w;
  w.LearnWhatIsNormal();
  const mission::Decision d = w.See(std::nullopt);
  ASSERT_TRUE(d.aid);
  EXPECT_EQ(d.phase, "by sight: own attitude silent");
  EXPECT_LT(Degrees(d.aid->R_NB.angularDistance(HeadingRotation(kYaw))), 0.7);
  EXPECT_TRUE(std::holds_alternative<control::PositionSetpoint>(*d.setpoint));
}

TEST(GyroFailure, TheVideoSaysThatTheOwnAttitudeHasFailed) {
  Watcher w;
  w.LearnWhatIsNormal();
  EXPECT_EQ(w.Captions().front().text, "by own attitude");
  EXPECT_FALSE(w.Captions().front().alarm);
  EXPECT_EQ(w.Struck(), 0);
  w.See(std::nullopt);
  EXPECT_EQ(w.Captions().front().text, "by sight: own attitude silent");
  EXPECT_TRUE(w.Captions().front().alarm);
  EXPECT_GT(w.Struck(), 300);
}

TEST(GyroFailure, AFrozenAttitudeIsReplacedAfterThreeFrames) {
  Watcher w;
  w.LearnWhatIsNormal();
  const Eigen::Quaterniond stuck = w.Sound();
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(w.See(stuck).aid);
  const mission::Decision d = w.See(stuck);
  EXPECT_TRUE(d.aid);
  EXPECT_EQ(d.phase, "by sight: own attitude frozen");
}

TEST(GyroFailure, AWrongAttitudeIsReplacedAfterThreeFramesAndOneBadFrameIsNot) {
  Watcher w;
  w.LearnWhatIsNormal();
  EXPECT_FALSE(w.See(w.Sound(20)).aid);
  EXPECT_FALSE(w.See(w.Sound()).aid);
  EXPECT_FALSE(w.See(w.Sound(2)).aid);
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(w.See(w.Sound(5)).aid);
  const mission::Decision d = w.See(w.Sound(5));
  ASSERT_TRUE(d.aid);
  EXPECT_EQ(d.phase, "by sight: own attitude wrong");
  EXPECT_LT(Degrees(d.aid->R_NB.angularDistance(HeadingRotation(kYaw))), 0.7);
}

TEST(GyroFailure, TheOwnAttitudeMustAgreeForAWhileBeforeItFliesAgain) {
  Watcher w;
  w.LearnWhatIsNormal();
  ASSERT_TRUE(w.See(std::nullopt).aid);
  int on_trial = 0;
  while (w.See(w.Sound()).aid) ASSERT_LT(++on_trial, 1000);
  EXPECT_NEAR(on_trial * kFrame_s, GyroFailureFlight{}.agree_s, 0.15);
  EXPECT_EQ(w.See(w.Sound()).phase, "by own attitude");
}

// Its sensors have drifted on while it was silent: what counts is that it is near and stays where it is.
TEST(GyroFailure, AnAttitudeThatComesBackWithAnotherLevelMayFlyAgain) {
  Watcher w;
  w.LearnWhatIsNormal();
  ASSERT_TRUE(w.See(std::nullopt).aid);
  int on_trial = 0;
  while (w.See(w.Sound(2.4)).aid) ASSERT_LT(++on_trial, 1000);
  EXPECT_NEAR(on_trial * kFrame_s, GyroFailureFlight{}.agree_s, 0.15);
  for (int i = 0; i < 40; ++i) ASSERT_EQ(w.See(w.Sound(2.4)).phase, "by own attitude") << i;
}

TEST(GyroFailure, AnAttitudeThatComesBackDriftingStaysOnTrial) {
  GyroFailureFlight flight;
  flight.disagree_deg = 12;
  Watcher w(flight);
  w.LearnWhatIsNormal();
  ASSERT_TRUE(w.See(std::nullopt).aid);
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(w.See(w.Sound(1.0 * i * kFrame_s)).aid) << i;  // 1 deg/s
}

TEST(GyroFailure, WithoutASkylineTheGyrosCarryOnForAWhileAndThenItIsBlind) {
  Watcher w;
  w.LearnWhatIsNormal();
  ASSERT_TRUE(w.See(std::nullopt).aid);
  int carried = 0;
  mission::Decision d = w.See(std::nullopt, true);
  EXPECT_EQ(d.target, "too_dark");
  for (; d.aid; d = w.See(std::nullopt, true)) ASSERT_LT(++carried, 1000);
  EXPECT_NEAR(carried * kFrame_s, GyroFailureFlight{}.coast_s, 0.15);
  EXPECT_EQ(d.phase, "blind");
}

TEST(GyroFailure, WithoutASkylineASilentAttitudeIsNotPassedOver) {
  Watcher w;
  for (int i = 0; i < 5; ++i) {
    const mission::Decision d = w.See(std::nullopt, true);
    EXPECT_FALSE(d.aid);
    EXPECT_EQ(d.phase, "blind");
  }
}

TEST(GyroFailure, AnAttitudeThatIsSilentFromTheFirstFrameIsReplacedAtOnce) {
  Watcher w;
  const mission::Decision d = w.See(std::nullopt);
  ASSERT_TRUE(d.aid);
  EXPECT_EQ(d.phase, "by sight: own attitude silent");
  EXPECT_LT(Degrees(d.aid->R_NB.angularDistance(HeadingRotation(kYaw))), 0.7);
}

TEST(GyroFailure, WhatCannotBeComparedIsNotOnTrial) {
  Watcher w;
  w.LearnWhatIsNormal();
  for (int i = 0; i < 3; ++i) w.See(w.Sound(8));
  mission::Decision d;
  for (int i = 0; i < 15; ++i) d = w.See(w.Sound(8), true);  // dark for longer than a sight is fresh
  EXPECT_EQ(d.phase, "by sight: own attitude wrong");
  const auto* report = mission::ReportOf<mission::HorizonReport>(d);
  ASSERT_TRUE(report);
  EXPECT_NEAR(report->coasting_s.value_or(-1), 15 * kFrame_s, 1e-6);
}

}  // namespace
}  // namespace kestrel::scenarios
