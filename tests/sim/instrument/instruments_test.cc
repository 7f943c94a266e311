// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/instruments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"
#include "sim/instrument/motion.h"
#include "sim/instrument/sample_clock.h"

namespace kestrel::sim {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

ImuParameters WithoutNoise() {
  ImuParameters imu;
  imu.accelerometer_noise_density = imu.accelerometer_random_walk = imu.accelerometer_turn_on_m_s2 = 0;
  imu.gyroscope_noise_density = imu.gyroscope_random_walk = imu.gyroscope_turn_on_rad_s = 0;
  return imu;
}

Truth AtRest(double t_s) {
  Truth truth;
  truth.t_s = t_s;
  truth.X_NB.p = {1, 2, -3};
  return truth;
}

// On a circle of 2 m about the origin, at a steady rate about the vertical, nose ahead.
constexpr double kTurn_rad_s = 3;
Truth Circling(double t_s) {
  const double angle = kTurn_rad_s * t_s;
  Truth truth;
  truth.t_s = t_s;
  truth.X_NB.p = {2 * std::cos(angle), 2 * std::sin(angle), -5};
  truth.X_NB.R = HeadingRotation(angle + std::numbers::pi / 2);
  truth.v_N = kTurn_rad_s * Eigen::Vector3d(-2 * std::sin(angle), 2 * std::cos(angle), 0);
  truth.w_B = {0, 0, kTurn_rad_s};
  return truth;
}

double NothingThere(const Eigen::Vector3d&, const Eigen::Vector3d&) { return kInfinite; }

// Of rates at an interval tau (IEEE 952): the root of half the mean square of the differences between
// neighbouring means over tau; of all axes together.
double AllanDeviation(const std::vector<Eigen::Vector3d>& rates, std::size_t in_a_mean) {
  std::vector<Eigen::Vector3d> means;
  for (std::size_t i = 0; i + in_a_mean <= rates.size(); i += in_a_mean) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = i; k < i + in_a_mean; ++k) sum += rates[k];
    means.emplace_back(sum / static_cast<double>(in_a_mean));
  }
  double squares = 0;
  for (std::size_t i = 1; i < means.size(); ++i) squares += (means[i] - means[i - 1]).squaredNorm() / 3;
  return std::sqrt(squares / (2 * static_cast<double>(means.size() - 1)));
}

struct AtRestFor {
  std::vector<Eigen::Vector3d> w_I, force_I;
  AtRestFor(const ImuParameters& imu, double duration_s) {
    Instruments instruments({.imu = imu}, 5);
    instruments.Step(AtRest(0), AtRest(duration_s), NothingThere);
    for (const ImuReading& reading : instruments.Take(duration_s).imu) {
      w_I.push_back(reading.w_I);
      force_I.push_back(reading.specific_force_I);
    }
  }
};

// White noise of density s: s / sqrt(tau), slope -1/2. A walk of density k: k sqrt(tau / 3), slope +1/2 (IEEE
// 952). A deviation from n differences on three axes is good to 1 in sqrt(6 n); differences that share a mean
// are not independent, and four of those are allowed.
TEST(Imu, AllanDeviationIsThatOfItsNoiseDensityAndRandomWalk) {
  ImuParameters imu;
  imu.rate_hz = 200;
  imu.gyroscope_noise_density = 1.7e-4, imu.accelerometer_noise_density = 2e-3;
  imu.gyroscope_random_walk = imu.accelerometer_random_walk = 0;
  const AtRestFor white(imu, 300);
  for (const std::size_t n : {1, 10, 100, 400}) {
    const double tau_s = static_cast<double>(n) / imu.rate_hz, within = 4 / std::sqrt(6 * 300 / tau_s);
    EXPECT_NEAR(AllanDeviation(white.w_I, n) / (1.7e-4 / std::sqrt(tau_s)), 1, within);
    EXPECT_NEAR(AllanDeviation(white.force_I, n) / (2e-3 / std::sqrt(tau_s)), 1, within);
  }
  imu.gyroscope_noise_density = imu.accelerometer_noise_density = 0;
  imu.gyroscope_random_walk = 2e-5, imu.accelerometer_random_walk = 3e-3;
  const AtRestFor walk(imu, 600);
  for (const std::size_t n : {50, 200, 1000, 4000}) {
    const double tau_s = static_cast<double>(n) / imu.rate_hz, within = 4 / std::sqrt(6 * 600 / tau_s);
    EXPECT_NEAR(AllanDeviation(walk.w_I, n) / (2e-5 * std::sqrt(tau_s / 3)), 1, within);
    EXPECT_NEAR(AllanDeviation(walk.force_I, n) / (3e-3 * std::sqrt(tau_s / 3)), 1, within);
  }
}

TEST(Imu, TheDensitiesDoNotDependOnTheRate) {
  for (const double rate_hz : {100.0, 1000.0}) {
    ImuParameters imu;
    imu.rate_hz = rate_hz;
    imu.gyroscope_random_walk = 0;
    const AtRestFor run(imu, 100);
    const double within = 4 / std::sqrt(6 * 100 / 0.1);
    EXPECT_NEAR(AllanDeviation(run.w_I, static_cast<std::size_t>(rate_hz / 10)) /
                    (imu.gyroscope_noise_density / std::sqrt(0.1)),
                1, within);
  }
}

TEST(Imu, WithoutNoiseReadsTheMotionBetweenTheStatesOnBothSides) {
  ImuParameters imu = WithoutNoise();
  imu.rate_hz = 1000, imu.phase_s = 0.0005;
  imu.position_m = {0.1, -0.2, 0.05};
  imu.yaw_deg = 90, imu.roll_deg = 180;
  Instruments instruments({.imu = imu}, 1);
  const Truth before = Circling(1), after = Circling(1.002);
  instruments.Step(Circling(0.998), before, NothingThere);
  instruments.Take(1);
  instruments.Step(before, after, NothingThere);
  const Readings readings = instruments.Take(1.002);
  ASSERT_EQ(readings.imu.size(), 2u);
  ASSERT_EQ(readings.truth.size(), 2u);
  // I: x to the right of the aircraft, y forward, z up.
  Eigen::Matrix3d R_BI;
  R_BI << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  for (std::size_t i = 0; i < 2; ++i) {
    const double share = i == 0 ? 0.25 : 0.75;
    EXPECT_EQ(readings.imu[i].t_ns, 1'000'500'000 + static_cast<std::int64_t>(i) * 1'000'000);
    EXPECT_EQ(readings.truth[i].t_ns, readings.imu[i].t_ns);
    EXPECT_TRUE(readings.truth[i].X_NB.p.isApprox((1 - share) * before.X_NB.p + share * after.X_NB.p, 1e-15));
    EXPECT_TRUE(readings.truth[i].v_N.isApprox((1 - share) * before.v_N + share * after.v_N, 1e-15));
    const double angle = kTurn_rad_s * (1 + 0.002 * share) + std::numbers::pi / 2;
    EXPECT_LT(readings.truth[i].X_NB.R.angularDistance(HeadingRotation(angle)), 1e-12);
    EXPECT_TRUE(readings.imu[i].w_I.isApprox(R_BI.transpose() * before.w_B, 1e-12));
    // Towards the centre of the circle, which is 2 m to the right of the aircraft. The acceleration is that of
    // the whole step, 1.5 mrad of the turn away.
    Eigen::Vector3d force_B = kTurn_rad_s * kTurn_rad_s * (Eigen::Vector3d(0, 2, 0) - imu.position_m);
    force_B.z() = -kGravity_m_s2;
    EXPECT_LT((readings.imu[i].specific_force_I - R_BI.transpose() * force_B).norm(), 0.06);
  }
}

TEST(Instruments, StampsAreRoundedEachByItselfAndNeverDrift) {
  const std::int64_t rate = 300, phase_ns = 1'234'567;
  SampleClock clock(static_cast<double>(rate), 1e-9 * static_cast<double>(phase_ns));
  for (std::int64_t k = 0; k < 36000 * rate; ++k, clock.Tick()) {
    if (k % 997 != 0) continue;
    const std::int64_t exact = phase_ns + (2 * k * 1'000'000'000 + rate) / (2 * rate);
    ASSERT_EQ(clock.next_ns(), exact) << k;
  }
}

TEST(Instruments, AReadingComesAfterItsLatencyWithTheStampOfItsOwnClock) {
  BarometerParameters barometer;
  barometer.rate_hz = 100, barometer.latency_s = 0.0305, barometer.clock_offset_s = -2.5;
  barometer.height_m = {0, 0, 1};
  Instruments instruments({.barometer = barometer}, 1);
  std::vector<std::int64_t> stamps;
  for (int step = 0; step < 50; ++step) {
    const double t_s = 0.002 * step, next_s = 0.002 * (step + 1);
    instruments.Step(AtRest(t_s), AtRest(next_s), NothingThere);
    for (const BarometerReading& reading : instruments.Take(next_s).barometer) {
      const std::int64_t made_ns = reading.t_ns + 2'500'000'000;
      EXPECT_GE(Nanoseconds(next_s), made_ns + 30'500'000);
      EXPECT_LT(Nanoseconds(t_s), made_ns + 30'500'000);
      EXPECT_EQ(reading.height_m, 3);
      stamps.push_back(made_ns);
    }
  }
  EXPECT_THAT(stamps, ::testing::ElementsAre(0, 10'000'000, 20'000'000, 30'000'000, 40'000'000, 50'000'000,
                                             60'000'000));
}

TEST(Instruments, NoneIsMadeBeforeTheFlightBegins) {
  Instruments instruments({.imu = WithoutNoise()}, 1);
  for (int step = -4; step < 0; ++step)
    instruments.Step(AtRest(0.002 * step), AtRest(0.002 * (step + 1)), NothingThere);
  const Readings readings = instruments.Take(0);
  ASSERT_EQ(readings.imu.size(), 1u);
  EXPECT_EQ(readings.imu.front().t_ns, 0);
  EXPECT_TRUE(readings.imu.front().specific_force_I.isApprox(Eigen::Vector3d(0, 0, -kGravity_m_s2)));
}

TEST(Instruments, AntennaBarometerAndFieldAreThoseOfTheMotion) {
  InstrumentParameters p;
  p.gps.emplace().horizontal_m = {0, 0, 1};
  p.gps->vertical_m = p.gps->velocity_m_s = {0, 0, 1};
  p.gps->position_m = {0, 0.5, -0.1};
  p.barometer.emplace().height_m = {0, 0, 1};
  p.magnetometer.emplace().white_t = 0;
  p.magnetometer->turn_on_t = 0;
  Instruments instruments(p, 1);
  const Truth truth = Circling(0);
  instruments.Step(Circling(-0.002), truth, NothingThere);
  const Readings readings = instruments.Take(0);
  ASSERT_EQ(readings.gps.size(), 1u);
  // It circles at 1.5 m where the aircraft circles at 2 m: east of north of the centre, heading east.
  EXPECT_TRUE(readings.gps[0].p_N.isApprox(Eigen::Vector3d(1.5, 0, -5.1), 1e-12));
  EXPECT_TRUE(readings.gps[0].v_N.isApprox(Eigen::Vector3d(0, 1.5 * kTurn_rad_s, 0), 1e-12));
  ASSERT_EQ(readings.barometer.size(), 1u);
  EXPECT_DOUBLE_EQ(readings.barometer[0].height_m, 5);
  // ISO 2533 by its layer's own formula: 15 degrees C and 6.5 K less for each km.
  const double pressure_pa =
      101325 * std::pow(1 - 0.0065 * 5 / 288.15, 9.80665 * 0.0289644 / (8.31432 * 0.0065));
  EXPECT_NEAR(readings.barometer[0].pressure_pa, pressure_pa, 0.05);
  ASSERT_EQ(readings.magnetometer.size(), 1u);
  const Eigen::Vector3d field_N = EarthField_N();
  EXPECT_TRUE(
      readings.magnetometer[0].field_B.isApprox(Eigen::Vector3d(0, -field_N.x(), field_N.z()), 1e-12));
}

TEST(Rangefinder, MeasuresAlongItsBeamWithinItsLimits) {
  const auto measure = [](double height_m, const RangefinderParameters& rangefinder) {
    Instruments instruments({.rangefinder = rangefinder}, 1);
    const auto level_ground = [](const Eigen::Vector3d& p_N, const Eigen::Vector3d& direction_N) {
      return direction_N.z() > 0 ? -p_N.z() / direction_N.z() : kInfinite;
    };
    Truth truth;
    truth.X_NB.p.z() = -height_m;
    Truth before = truth;
    before.t_s = -0.002;
    instruments.Step(before, truth, level_ground);
    return instruments.Take(0).rangefinder.at(0).range_m;
  };
  RangefinderParameters p;
  p.noise_m = 0, p.min_m = 0.5, p.max_m = 20;
  p.position_m = {0, 0, 0.1};
  EXPECT_NEAR(measure(7, p), 6.9, 1e-12);
  EXPECT_EQ(measure(0.55, p), -kInfinite);
  EXPECT_EQ(measure(20.2, p), kInfinite);
  p.direction = {1, 0, 1};
  EXPECT_NEAR(measure(7, p), 6.9 * std::numbers::sqrt2, 1e-12);
  p.direction = {1, 0, 0};
  EXPECT_EQ(measure(7, p), kInfinite);
}

TEST(Instruments, OneMoreChangesNoneOfTheOthers) {
  const auto run = [](const InstrumentParameters& p) {
    Instruments instruments(p, 9);
    instruments.Step(AtRest(0), AtRest(1), NothingThere);
    return instruments.Take(1);
  };
  InstrumentParameters p;
  p.gps.emplace();
  const Readings alone = run(p);
  p.imu.emplace(), p.barometer.emplace(), p.magnetometer.emplace(), p.rangefinder.emplace();
  const Readings all = run(p);
  ASSERT_EQ(alone.gps.size(), 6u);
  ASSERT_EQ(all.gps.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(alone.gps[i].p_N, all.gps[i].p_N);
  EXPECT_EQ(all.imu.size(), 201u);
  EXPECT_EQ(all.truth.size(), 201u);
}

}  // namespace
}  // namespace kestrel::sim
