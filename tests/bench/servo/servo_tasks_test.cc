// SPDX-License-Identifier: Apache-2.0
#include "bench/servo/servo_tasks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector3d;

const Pose kGoal{Eigen::Quaterniond::Identity(), {0, 0, -2}};

ServoTrialOptions Options() {
  return {.camera = {.width_px = 640, .height_px = 480, .fx = 810, .fy = 810, .cx = 319.5, .cy = 239.5}};
}

ServoTask AboutTheAxis(double angle_deg) {
  return {"", kGoal * Pose{ExpRotation({0, 0, Radians(angle_deg)}), {0, 0, 0}}, kGoal};
}
ServoTask AlongTheAxis(double from_m) {
  return {"", {Eigen::Quaterniond::Identity(), {0, 0, -from_m}}, kGoal};
}

TEST(ServoTasks, BeginAwayFromTheGoalWithAllPointsInView) {
  for (const ServoTask& task : ServoTasks()) {
    ServoTrialOptions options = Options();
    options.limit_s = 0;
    const ServoTrial trial = FlyServoTask(task, ServoLaw::kPose, options);
    EXPECT_TRUE(trial.in_view) << task.name;
    EXPECT_GT(trial.final_px, 10) << task.name;
  }
}

TEST(ServoTasks, TheMetricsOfAPureTranslationAreThoseOfItsClosedForm) {
  // By the pose the way falls as exp(-t): 4 m too far at first. The corners stand at f h sqrt 2 / Z.
  const ServoTrialOptions options = Options();
  const ServoTrial away = FlyServoTask(AlongTheAxis(6), ServoLaw::kPose, options);
  EXPECT_EQ(away.end, ServoEnd::kConverged);
  EXPECT_NEAR(away.retreat_m, 0, 1e-12);
  const double corner = 810 * 0.25 * std::sqrt(2.0);
  EXPECT_NEAR(away.excursion_px, corner / 2, 1e-6);
  // 1 px is left where corner / 2 - corner / Z = 1
  const double left_m = corner / (corner / 2 - 1) - 2;
  // Euler's steps of 0.02 s are faster than the exponential by 1 %.
  EXPECT_NEAR(away.converged_s, std::log(4 / left_m) / (-std::log(1 - 0.02) / 0.02), 0.02);
  EXPECT_LT(away.final_px, 1e-6);

  const ServoTrial near = FlyServoTask(AlongTheAxis(1.2), ServoLaw::kPose, options);
  EXPECT_NEAR(near.excursion_px, corner / 1.2, 1e-6);
  EXPECT_TRUE(near.in_view);
  // 290 px above the middle of an image of 480
  EXPECT_FALSE(FlyServoTask(AlongTheAxis(0.7), ServoLaw::kPose, options).in_view);
}

TEST(ServoTasks, ATurnByThePoseIsAPureTurnAndByThePointsARetreatToo) {
  const double corner_px = 810 * 0.25 * std::sqrt(2.0) / 2;
  const ServoTrial pose = FlyServoTask(AboutTheAxis(90), ServoLaw::kPose, Options());
  EXPECT_EQ(pose.end, ServoEnd::kConverged);
  EXPECT_LT(pose.retreat_m, 1e-9);
  EXPECT_NEAR(pose.excursion_px, corner_px, 1e-6);
  const ServoTrial points = FlyServoTask(AboutTheAxis(90), ServoLaw::kPointsCurrent, Options());
  EXPECT_EQ(points.end, ServoEnd::kConverged);
  // On straight lines in the image the corners of a quarter turn come within cos 45 degrees of the middle, so
  // the camera goes back from 2 m to 2.83 m.
  EXPECT_NEAR(points.retreat_m, 2 * (std::sqrt(2.0) - 1), 0.05);
}

TEST(ServoTasks, HalfATurnEndsByEachLawAsItsMatrixSays) {
  const auto end = [](ServoLaw law) { return FlyServoTask(AboutTheAxis(180), law, Options()).end; };
  EXPECT_EQ(end(ServoLaw::kPointsCurrent), ServoEnd::kRetreated);
  EXPECT_EQ(end(ServoLaw::kPointsDesired), ServoEnd::kCrossed);
  EXPECT_EQ(end(ServoLaw::kPointsMean), ServoEnd::kStalled);
  EXPECT_EQ(end(ServoLaw::kPose), ServoEnd::kConverged);
  EXPECT_EQ(end(ServoLaw::kPoseTarget), ServoEnd::kConverged);
}

TEST(ServoTasks, WithoutTimeThereIsNoConvergenceAndNoTimeOfIt) {
  ServoTrialOptions options = Options();
  options.limit_s = 1;
  const ServoTrial trial = FlyServoTask(AlongTheAxis(6), ServoLaw::kPointsCurrent, options);
  EXPECT_EQ(trial.end, ServoEnd::kTimeOut);
  EXPECT_EQ(trial.converged_s, 0);
  EXPECT_GT(trial.final_px, 1);
}

}  // namespace
}  // namespace kestrel::bench
