// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/place_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "vision/aircraft/ground_camera.h"

namespace kestrel::vision {
namespace {

const Pose kMast = MastPose({.position_m = {-13, 5, 2.5}, .yaw_deg = -20, .pitch_deg = 6, .roll_deg = 1});

// White errors of these sizes; the path is a helix of this radius.
std::vector<PlaceSighting> Sightings(double radius_m, unsigned seed, int count = 300) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto any = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  std::vector<PlaceSighting> all;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.05 * i;
    const Eigen::Vector3d p_TB(radius_m * std::cos(angle), radius_m * std::sin(angle), -3 - 2.0 * i / count);
    PlaceSighting s;
    s.p_TB = p_TB + s.sigma_m * any();
    const Eigen::Vector3d p_GB = kMast.Inverse() * p_TB;
    const double range = p_GB.norm() + s.range_sigma_m * normal(random);
    s.p_GB = range * (p_GB.normalized() + s.bearing_sigma * any()).normalized();
    all.push_back(s);
  }
  return all;
}

// Shift and turn of what was found off the truth.
Eigen::Matrix<double, 6, 1> Off(const PlaceCalibration& found) {
  Eigen::Matrix<double, 6, 1> off;
  off << found.X_TG.p - kMast.p, LogRotation(found.X_TG.R * kMast.R.conjugate());
  return off;
}

TEST(PlaceCalibration, FindsTheMastWithTheErrorThatItsCovarianceTells) {
  double squared = 0;
  constexpr int kTrials = 30;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const PlaceCalibration found = CalibratePlace(Sightings(1.5, seed), 1, 1);
    ASSERT_EQ(found.state, PlaceState::kFound) << NameOf(found.state);
    EXPECT_LT(Off(found).head<3>().norm(), 0.12);
    EXPECT_LT(Off(found).tail<3>().norm(), 0.006);
    squared += Off(found).dot(found.covariance.inverse() * Off(found));
  }
  EXPECT_NEAR(squared / kTrials, 6, 2);
}

TEST(PlaceCalibration, StandsSomeFixesThatAreFarOff) {
  std::vector<PlaceSighting> all = Sightings(1.5, 3);
  for (std::size_t i = 0; i < all.size(); i += 15) all[i].p_TB += Eigen::Vector3d(1, -1, 0.5);
  const PlaceCalibration found = CalibratePlace(all, 1, 1);
  EXPECT_EQ(found.state, PlaceState::kFound);
  EXPECT_LT(Off(found).head<3>().norm(), 0.15);
}

TEST(PlaceCalibration, SaysOfAPathThatIsALineThatTheMastMayTurnAboutIt) {
  EXPECT_EQ(CalibratePlace(Sightings(0.01, 3), 1, 1).state, PlaceState::kNotSpread);
  EXPECT_EQ(CalibratePlace(Sightings(1.5, 3, 20), 1, 1).state, PlaceState::kTooFew);
}

TEST(PlaceCalibration, TakesErrorsThatLastForFewerMeasurements) {
  const auto all = Sightings(1.5, 3);
  const double white = CalibratePlace(all, 0.1, 0.1).covariance.trace();
  const double lasting = CalibratePlace(all, 0.1, 1).covariance.trace();
  EXPECT_NEAR(lasting / white, 10, 1e-6);
}

}  // namespace
}  // namespace kestrel::vision
