// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "geometry/pose.h"
#include "tests/support/temporary_folder.h"
#include "vision/enhance/stabilisation/gyro_file.h"
#include "vision/enhance/stabilisation/gyro_offset.h"
#include "vision/enhance/stabilisation/gyro_track.h"

namespace kestrel::vision {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d Rate(double t_s) {
  return {0.5 * std::sin(7 * t_s), 0.4 * std::cos(11 * t_s), 0.3 * std::sin(3 * t_s + 1)};
}

// Stamped by a clock that shows offset_s more.
std::vector<GyroSample> Samples(double offset_s = 0, double to_s = 4) {
  std::vector<GyroSample> samples;
  for (int i = 0; i <= static_cast<int>(200 * to_s); ++i)
    samples.push_back({i / 200.0 + offset_s, Rate(i / 200.0)});
  return samples;
}

TEST(GyroTrack, TurnsAsManySmallStepsDo) {
  const GyroTrack track(Samples());
  Quaterniond R_NC = Quaterniond::Identity();
  constexpr double kStep_s = 1e-4;
  for (int i = 0; i < 20037; ++i) R_NC = R_NC * ExpRotation(kStep_s * Rate((i + 0.5) * kStep_s));
  const auto at = track.At(20037 * kStep_s);
  ASSERT_TRUE(at);
  EXPECT_LT(at->angularDistance(R_NC), 1e-4);
}

TEST(GyroTrack, RowsAreAroundTheMiddleOne) {
  const GyroTrack track(Samples());
  const auto rows = track.Rows(1, 0.03, 5), back = track.Rows(1, -0.03, 5);
  ASSERT_EQ(rows.size(), 5u);
  ASSERT_EQ(back.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const double t_s = 1 + 0.03 * (static_cast<double>(i) / 4 - 0.5);
    EXPECT_LT(rows[i].angularDistance(*track.At(t_s)), 1e-9);
    EXPECT_LT(back[4 - i].angularDistance(rows[i]), 1e-9);
  }
  EXPECT_EQ(track.Rows(1, 0).size(), 1u);
}

TEST(GyroTrack, KnowsNothingBeyondItsEndsAndInGaps) {
  std::vector<GyroSample> samples = Samples();
  samples.erase(samples.begin() + 200, samples.begin() + 240);
  const GyroTrack track(samples);
  EXPECT_TRUE(track.At(0.5));
  EXPECT_FALSE(track.At(1.1));
  EXPECT_TRUE(track.At(1.5));
  EXPECT_FALSE(track.At(-0.001));
  EXPECT_FALSE(track.At(4.001));
  EXPECT_TRUE(track.Rows(3.99, 0.03).empty());
}

TEST(GyroOffset, AnotherClockIsFound) {
  const GyroTrack truth(Samples(0, 8));
  std::vector<ImageTurn> turns;
  for (int i = 30; i < 150; ++i) {
    const double from_s = i / 30.0, to_s = (i + 1) / 30.0;
    turns.push_back({from_s, to_s, LogRotation(truth.At(from_s)->conjugate() * *truth.At(to_s))});
  }
  for (const double offset_s : {0.0, 0.137, -0.4321}) {
    std::vector<GyroSample> samples = Samples(offset_s, 8);
    for (GyroSample& sample : samples) sample.w_C += Vector3d(0.02, -0.01, 0.03);  // a bias
    const auto found = EstimateGyroOffset(turns, GyroTrack(samples), 1);
    ASSERT_TRUE(found) << offset_s;
    EXPECT_NEAR(found->offset_s, offset_s, 5e-4);
    EXPECT_LT(found->unlike, 0.02);
    EXPECT_EQ(found->turns, 120);
  }
  EXPECT_FALSE(EstimateGyroOffset(turns, truth, 0.5)->other_s);
  // A gyro of another flight, and one whose times do not reach the video's.
  std::vector<GyroSample> other = Samples(0, 8);
  for (GyroSample& sample : other)
    sample.w_C = {0.4 * std::sin(23 * sample.t_s), 0, 0.5 * std::cos(17 * sample.t_s)};
  EXPECT_FALSE(EstimateGyroOffset(turns, GyroTrack(other), 1));
  EXPECT_FALSE(EstimateGyroOffset(turns, GyroTrack(Samples(100, 8)), 1));
}

// To and fro every 0.8 s: so much earlier or later it is the same.
TEST(GyroOffset, ATurningThatRepeatsItselfHasAnotherOne) {
  std::vector<GyroSample> samples;
  for (int i = 0; i <= 2000; ++i)
    samples.push_back({i / 200.0, {0, 0.5 * std::sin(2 * std::numbers::pi * i / 160.0), 0}});
  const GyroTrack truth(samples);
  std::vector<ImageTurn> turns;
  for (int i = 60; i < 200; ++i) {
    const double from_s = i / 30.0, to_s = (i + 1) / 30.0;
    turns.push_back({from_s, to_s, LogRotation(truth.At(from_s)->conjugate() * *truth.At(to_s))});
  }
  const auto wide = EstimateGyroOffset(turns, truth, 1), narrow = EstimateGyroOffset(turns, truth, 0.3);
  ASSERT_TRUE(wide && narrow);
  ASSERT_TRUE(wide->other_s);
  EXPECT_NEAR(std::abs(*wide->other_s - wide->offset_s), 0.8, 0.011);
  EXPECT_FALSE(narrow->other_s);
}

class GyroFile : public InTemporaryFolder {
 protected:
  std::vector<GyroSample> Read(const std::string& text) {
    const auto file = folder_ / "gyro.csv";
    std::ofstream(file) << text;
    return ReadGyroFile(file.string(), mistakes_);
  }
  Mistakes mistakes_;
};

TEST_F(GyroFile, ColumnsAreFoundByTheirNames) {
  const auto samples = Read("wz_deg_s,t_s,other,wx_deg_s,wy_deg_s\n180,1,x,0,90\n180,1.5,x,0,-90\n");
  ASSERT_TRUE(mistakes_.all().empty());
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].t_s, 1.5);
  EXPECT_LT((samples[0].w_C - std::numbers::pi * Vector3d(0, 0.5, 1)).norm(), 1e-12);
}

TEST_F(GyroFile, WhatIsWrongIsAMistake) {
  std::size_t mistakes = 0;
  for (const char* text :
       {"", "t_s,wx_rad_s,wy_rad_s\n0,1,2\n1,1,2\n", "t_s,wx_rad_s,wy_rad_s,wz_rad_s\n0,1,2,3\n",
        "t_s,wx_rad_s,wy_rad_s,wz_rad_s\n0,1,2,3\n1,1,nan,3\n",
        "t_s,wx_rad_s,wy_rad_s,wz_rad_s\n0,1,2,3\n0,1,2,3\n"}) {
    Read(text);
    EXPECT_EQ(mistakes_.all().size(), ++mistakes) << text;
  }
}

}  // namespace
}  // namespace kestrel::vision
