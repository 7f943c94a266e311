// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/horizon_stills.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "bench/horizon/horizon_judgement.h"

namespace kestrel::bench {
namespace {

std::vector<StillLandscape> TwoWorlds() {
  StillLandscape clear{"clear", {}}, hazy{"hazy", {}};
  hazy.parameters.haze_m = 7000;
  return {clear, hazy};
}

TEST(HorizonStills, TheSeedAloneDrawsThem) {
  const StillSweep a = DrawSweep(TwoWorlds(), 5, 20, 3), b = DrawSweep(TwoWorlds(), 5, 20, 3),
                   other = DrawSweep(TwoWorlds(), 5, 20, 4);
  ASSERT_EQ(a.landscapes.size(), 10u);
  ASSERT_EQ(a.stills.size(), 200u);
  for (std::size_t i = 0; i < a.stills.size(); ++i) {
    EXPECT_EQ(a.stills[i].attitude.roll, b.stills[i].attitude.roll);
    EXPECT_EQ(a.stills[i].expected, b.stills[i].expected);
    EXPECT_NE(a.stills[i].attitude.roll, other.stills[i].attitude.roll);
  }
  std::set<std::uint64_t> seeds;
  for (const StillLandscape& l : a.landscapes) seeds.insert(l.parameters.seed);
  EXPECT_EQ(seeds.size(), 10u);
}

TEST(HorizonStills, TheyFillTheirRangesEvenlyInEachLandscapeToo) {
  const StillSweep sweep = DrawSweep(TwoWorlds(), 10, 52, 1);
  std::array<int, 8> rolls{}, pitches{}, heights{};
  std::array<int, 4> rolls_of_first{};
  for (const Still& s : sweep.stills) {
    const double roll = (Degrees(s.attitude.roll) + 45) / 90, pitch = (Degrees(s.attitude.pitch) + 45) / 90,
                 height = std::log(s.height_m / 2) / std::log(250);
    for (const double u : {roll, pitch, height}) {
      ASSERT_GE(u, -1e-12);
      ASSERT_LT(u, 1 + 1e-12);
    }
    ++rolls.at(static_cast<std::size_t>(8 * roll));
    ++pitches.at(static_cast<std::size_t>(8 * pitch));
    ++heights.at(static_cast<std::size_t>(8 * height));
    if (s.landscape == 0) ++rolls_of_first.at(static_cast<std::size_t>(4 * roll));
    EXPECT_LE(s.place_m.norm(), 250);
  }
  // 130 in each; even draws of chance would stray by 11.
  for (const auto& counts : {rolls, pitches, heights})
    for (const int n : counts) EXPECT_NEAR(n, 130, 6);
  for (const int n : rolls_of_first) EXPECT_NEAR(n, 13, 2);
}

TEST(HorizonStills, LandscapesKeepWithinWhatIsSaidOfThem) {
  const StillSweep sweep = DrawSweep(TwoWorlds(), 50, 1, 2);
  int without_ridge = 0;
  for (const StillLandscape& l : sweep.landscapes) {
    const double usual_m = l.world == "hazy" ? 7000 : 30000;
    EXPECT_GE(l.parameters.haze_m, 0.3 * usual_m);
    EXPECT_LE(l.parameters.haze_m, 1.5 * usual_m);
    EXPECT_LE(l.parameters.ridge.height_deg, 10);
    without_ridge += l.parameters.ridge.height_deg == 0;
  }
  EXPECT_NEAR(without_ridge, 30, 3);
}

TEST(HorizonStills, WhatIsExpectedErrsByTheDeviationThatIsSaid) {
  const StillSweep sweep = DrawSweep(TwoWorlds(), 10, 52, 1);
  const Eigen::Vector3d down = Eigen::Vector3d(0.2, -0.4, 0.8).normalized();
  double sum = 0;
  for (const Still& s : sweep.stills) {
    const Eigen::Vector3d expected = ExpectedDown(down, s);
    EXPECT_NEAR(expected.norm(), 1, 1e-12);
    sum += std::pow(std::acos(std::min(1.0, expected.dot(down))), 2);
  }
  const double root = std::sqrt(sum / static_cast<double>(sweep.stills.size()));
  EXPECT_NEAR(Degrees(root), 1.5 * std::sqrt(2), 0.1);
}

// A fix that is off by so much about the nose and about the right wing, of a camera that lies along B.
JudgedStill Off(double roll_deg, double pitch_deg, double sigma_deg) {
  JudgedStill judged;
  judged.X_NB.R = Eigen::Quaterniond::Identity();
  vision::SkylineFix fix;
  fix.down_C = RotationFromTaitBryan({0, Radians(pitch_deg), Radians(roll_deg)}).transpose() *
               Eigen::Vector3d::UnitZ();
  fix.covariance =
      std::pow(Radians(sigma_deg), 2) * (Eigen::Matrix3d::Identity() - fix.down_C * fix.down_C.transpose());
  judged.answers[kAlone] = Judge(vision::SkylineResult(fix), Eigen::Matrix3d::Identity(), judged.X_NB);
  judged.answers[kExpecting] = Judge(vision::NoSkyline::kUneven, Eigen::Matrix3d::Identity(), judged.X_NB);
  return judged;
}

TEST(HorizonJudgement, ErrorsAreThoseOfRollAndPitchAgainstTheTruth) {
  const Answer a = Off(0.6, -0.8, 0.5).answers[kAlone];
  EXPECT_NEAR(a.roll_error_deg, 0.6, 1e-9);
  EXPECT_NEAR(a.pitch_error_deg, -0.8, 1e-9);
  EXPECT_NEAR(a.error_deg, 1.0, 1e-3);
  EXPECT_NEAR(a.roll_sigma_deg, 0.5, 1e-3);
  EXPECT_NEAR(a.pitch_sigma_deg, 0.5, 1e-3);
  EXPECT_FALSE(a.Outlier());
  EXPECT_TRUE(Off(4, 3.1, 1).answers[kAlone].Outlier());
  EXPECT_FALSE(Off(4, 2.9, 1).answers[kAlone].Outlier());
}

TEST(HorizonJudgement, StatisticsCountWhatWasSaid) {
  const std::vector<JudgedStill> all = {Off(1, 0, 1), Off(-1, 0, 0.4), Off(6, 0, 4)};
  const auto everything = [](const JudgedStill&) { return true; };
  const Statistics alone = StatisticsOf(all, kAlone, everything);
  EXPECT_EQ(alone.stills, 3);
  EXPECT_EQ(alone.fixes, 3);
  EXPECT_EQ(alone.outliers, 1);
  EXPECT_NEAR(alone.roll_rmse_deg, std::sqrt(38.0 / 3), 1e-6);
  EXPECT_NEAR(alone.roll_bias_deg, 2, 1e-6);
  EXPECT_NEAR(alone.within_2_sigma, 5.0 / 6, 1e-9);  // all pitches, and rolls but the second
  EXPECT_NEAR(alone.median_deg, 1, 1e-6);
  const Statistics expecting = StatisticsOf(all, kExpecting, everything);
  EXPECT_EQ(expecting.fixes, 0);
  EXPECT_EQ(expecting.refused.at("uneven_skyline"), 3);
}

TEST(HorizonJudgement, EveryStillHasItsRangeOfEachFactor) {
  JudgedStill s = Off(0, 0, 1);
  s.landscape = {"winter_cloudy", {}};
  s.landscape.parameters.haze_m = 4999;
  s.still.height_m = 6.5;
  s.tilt_deg = 60;
  s.ridge_deg = 0;
  s.sun = "overcast";
  std::vector<std::string> ranges;
  for (const Factor& factor : Factors())
    ranges.push_back(factor.ranges.at(static_cast<std::size_t>(factor.of(s))));
  EXPECT_EQ(ranges, (std::vector<std::string>{"winter_cloudy", "6 to 20 m", "45 to 60 deg", "none",
                                              "0 to 5 km", "overcast"}));
  s.ridge_deg = 3.5;
  EXPECT_EQ(Factors()[3].ranges.at(static_cast<std::size_t>(Factors()[3].of(s))), "3 to 6 deg");
}

}  // namespace
}  // namespace kestrel::bench
