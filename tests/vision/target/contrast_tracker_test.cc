// SPDX-License-Identifier: Apache-2.0
#include "vision/target/contrast_tracker.h"

#include <gtest/gtest.h>

#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "tests/vision/target/contrast_photographer.h"

namespace kestrel::vision {
namespace {

constexpr double kStep_s = 0.05;

Eigen::Vector3d Towards(double azimuth_deg, double elevation_deg) {
  const double a = Radians(azimuth_deg), e = Radians(elevation_deg);
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), -std::sin(e)};
}

// A camera that sways before one sky, painted once for each of some attitudes.
class Flight {
 public:
  explicit Flight(const ContrastTrackerOptions& options = {}) : tracker(ForwardFisheye(), {}, options) {}
  static Eigen::Matrix3d Attitude(int k) {
    return RotationFromTaitBryan({0.02 * (k % 4), 0.02 * (k % 2), 0.03 * (k / 2 % 2)}) * LooksForward();
  }
  ContrastObservation Step(const std::vector<FlyingBall>& balls) {
    static const SkylinePhotographer photographer(ForwardFisheye());
    static std::map<int, cv::Mat> skies;
    const int k = image++, sky = k % 4;
    if (!skies.contains(sky)) skies[sky] = photographer.Paint({}, Attitude(sky), sky);
    cv::Mat bgr = skies[sky].clone();
    PaintFlyingBalls(bgr, ForwardFisheye(), Attitude(k), balls);
    return tracker.Track(bgr, Attitude(k), kStep_s * k);
  }
  ContrastTracker tracker;
  int image = 0;
};

TEST(ContrastTracker, TwoAtOnceAreConfirmedEachWithItsOwnIdAndBearing) {
  Flight flight;
  std::set<int> left, right;
  int confirmed = 0;
  for (int k = 0; k < 16; ++k) {
    const Eigen::Vector3d one = Towards(-25 + 0.3 * k, 20), other = Towards(20, 12);
    const ContrastObservation seen = flight.Step({{one, 0.012}, {other, 0.02, {240, 240, 245}}});
    EXPECT_EQ(seen.state, k < 5 ? ContrastState::kTentative : ContrastState::kConfirmed);
    for (const ContrastTarget& t : seen.targets) {
      if (!t.confirmed) continue;
      ++confirmed;
      const bool is_one = t.bearing_N.dot(one) > std::cos(0.002);
      EXPECT_TRUE(is_one || t.bearing_N.dot(other) > std::cos(0.002));
      (is_one ? left : right).insert(t.id);
      EXPECT_NEAR(t.seen.cone.half_angle, is_one ? 0.012 : 0.02, 0.001);
      if (k == 15) {
        EXPECT_NEAR(t.bearing_rate_N.norm(), is_one ? Radians(0.3) * std::cos(Radians(20)) / kStep_s : 0,
                    0.006);
      }
    }
    if (k >= 5) {
      ASSERT_TRUE(seen.Confirmed());
      EXPECT_NEAR(seen.Confirmed()->seen.cone.half_angle, 0.02, 0.001);  // the larger one
    }
  }
  EXPECT_EQ(left.size(), 1u);
  EXPECT_EQ(right.size(), 1u);
  EXPECT_NE(*left.begin(), *right.begin());
  EXPECT_EQ(confirmed, 2 * 11);
}

TEST(ContrastTracker, WhatShowsInOneImageIsNeverConfirmed) {
  Flight flight;
  for (int k = 0; k < 40; ++k) {
    // Each time elsewhere, and nothing in between.
    const bool there = k % 2 == 0;
    const ContrastObservation seen =
        flight.Step(there ? std::vector<FlyingBall>{{Towards(-50 + 13 * (k % 9), 10 + 5 * (k % 4)), 0.012}}
                          : std::vector<FlyingBall>{});
    EXPECT_EQ(seen.state, there ? ContrastState::kTentative : ContrastState::kSearching) << k;
    EXPECT_FALSE(seen.Confirmed());
    EXPECT_TRUE(seen.lost.empty());
  }
}

TEST(ContrastTracker, ALostOneLeavesNoPlaceAndComesBackWithItsId) {
  Flight flight;
  const FlyingBall ball{Towards(5, 15), 0.012};
  ContrastObservation seen;
  for (int k = 0; k < 10; ++k) seen = flight.Step({ball});
  ASSERT_TRUE(seen.Confirmed());
  const int id = seen.Confirmed()->id;
  for (int k = 0; k < 8; ++k) {
    seen = flight.Step({});
    EXPECT_EQ(seen.state, ContrastState::kLost);
    EXPECT_TRUE(seen.targets.empty());
    EXPECT_EQ(seen.lost, std::vector<int>{id});
  }
  seen = flight.Step({ball});
  ASSERT_TRUE(seen.Confirmed());
  EXPECT_EQ(seen.Confirmed()->id, id);
  // Away for longer than it is remembered.
  for (int k = 0; k < 42; ++k) seen = flight.Step({});
  EXPECT_EQ(seen.state, ContrastState::kSearching);
  for (int k = 0; k < 8; ++k) seen = flight.Step({ball});
  ASSERT_TRUE(seen.Confirmed());
  EXPECT_NE(seen.Confirmed()->id, id);
}

TEST(ContrastTracker, TheTimeToContactIsTheInverseOfTheGrowth) {
  Flight flight;
  constexpr double kRadius_m = 0.5, kSpeed_m_s = 5;
  int checked = 0;
  for (int k = 0; k < 60; ++k) {
    const double range = 25 - kSpeed_m_s * kStep_s * k;
    const ContrastObservation seen = flight.Step({{Towards(-10, 18), std::asin(kRadius_m / range)}});
    if (k < 25) continue;
    ASSERT_TRUE(seen.Confirmed());
    ASSERT_TRUE(seen.Confirmed()->growth);
    const ContrastGrowth& growth = *seen.Confirmed()->growth;
    EXPECT_NEAR(growth.rate_1_s, kSpeed_m_s / range, 4 * growth.sigma_1_s);
    EXPECT_NEAR(growth.rate_1_s * range / kSpeed_m_s, 1, 0.25);
    EXPECT_LT(growth.sigma_1_s, 0.1);
    ++checked;
  }
  EXPECT_EQ(checked, 35);
}

TEST(ContrastTracker, BadImagesAndTimesAreNamedAndHoldNoTarget) {
  Flight flight;
  for (int k = 0; k < 8; ++k) flight.Step({{Towards(5, 15), 0.012}});
  const Eigen::Matrix3d R_NC = LooksForward();
  const cv::Mat sky(480, 640, CV_8UC3, cv::Scalar(200, 150, 120));
  const auto state = [&](const cv::Mat& image, const Eigen::Matrix3d& R, double t_s) {
    const ContrastObservation seen = flight.tracker.Track(image, R, t_s);
    EXPECT_TRUE(seen.targets.empty());
    return seen.state;
  };
  EXPECT_EQ(state({}, R_NC, 1), ContrastState::kBadImage);
  EXPECT_EQ(state(sky, 2 * R_NC, 2), ContrastState::kBadImage);
  EXPECT_EQ(state(sky, R_NC, 0.5), ContrastState::kBadImage);  // earlier than the last
  EXPECT_EQ(state(sky, R_NC, std::nan("")), ContrastState::kBadImage);
  EXPECT_EQ(state(cv::Mat::zeros(480, 640, CV_8UC3), R_NC, 3), ContrastState::kTooDark);
  EXPECT_EQ(state(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(255)), R_NC, 4), ContrastState::kWhiteOut);
  EXPECT_STREQ(NameOf(ContrastState::kWhiteOut), "white out");
}

}  // namespace
}  // namespace kestrel::vision
