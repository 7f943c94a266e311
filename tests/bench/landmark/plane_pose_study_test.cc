// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/plane_pose_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kestrel::bench {
namespace {

TEST(RadicalInverse, MirrorsTheDigits) {
  const std::vector<double> two = {1 / 2.0, 1 / 4.0, 3 / 4.0, 1 / 8.0, 5 / 8.0};
  const std::vector<double> three = {1 / 3.0, 2 / 3.0, 1 / 9.0, 4 / 9.0, 7 / 9.0};
  for (std::uint64_t i = 1; i <= 5; ++i) {
    EXPECT_DOUBLE_EQ(RadicalInverse(i, 2), two[i - 1]);
    EXPECT_NEAR(RadicalInverse(i, 3), three[i - 1], 1e-15);
  }
}

// Where the target is large and tilted the model is as good as linear: what is likeliest reaches the bound.
TEST(PlanePoseStudy, TheMostLikelyPoseReachesTheBoundWhereTheTargetIsLarge) {
  PlanePoseStudy study{.camera = {640, 480, 810, 810, 319.5, 239.5}};
  study.poses = 200, study.to_m = 3, study.sigma_px = 0.1;
  double bound = 0, place = 0, bound_turn = 0, turn = 0;
  const auto trials = RunPlanePoseStudy(study, 3);
  ASSERT_EQ(trials.size(), 200u);
  for (const PlanePoseTrial& trial : trials) {
    ASSERT_TRUE(trial.errors[4]);
    bound += trial.bound.place_m2, place += trial.errors[4]->place_m2;
    bound_turn += trial.bound.turn_rad2, turn += trial.errors[4]->turn_rad2;
    EXPECT_NEAR(trial.size_px, std::sqrt(1.19 * 0.91 * std::cos(trial.tilt_rad)) * 810 / trial.distance_m,
                1e-6);
  }
  EXPECT_NEAR(place / bound, 1, 0.3);
  EXPECT_NEAR(turn / bound_turn, 1, 0.3);
}

}  // namespace
}  // namespace kestrel::bench
