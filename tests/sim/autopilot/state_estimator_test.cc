// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/state_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/tait_bryan.h"
#include "tests/sim/perfect_sensors.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kDt = 0.002;
constexpr double kGravity = 9.80665;
const Vector3d kZero = Vector3d::Zero();

struct Motion {
  Pose X_NB;
  Vector3d v_N, a_N, w_B;
};
using Path = std::function<Motion(double)>;

// A level circle, clockwise from above, flown as a coordinated turn: the nose along the course, banked so
// that the specific force is along the body's z. In closed form.
Motion BankedCircle(double t_s) {
  constexpr double kSpeed_m_s = 3, kRadius_m = 6;
  const double w = kSpeed_m_s / kRadius_m, yaw = w * t_s;
  Motion m;
  m.X_NB.p = Vector3d(kRadius_m * std::sin(yaw), kRadius_m * (1 - std::cos(yaw)), -8);
  m.v_N = kSpeed_m_s * Vector3d(std::cos(yaw), std::sin(yaw), 0);
  m.a_N = kSpeed_m_s * w * Vector3d(-std::sin(yaw), std::cos(yaw), 0);
  m.X_NB.R = RotationFromTaitBryan({yaw, 0, std::atan(kSpeed_m_s * w / kGravity)});
  m.w_B = m.X_NB.R.conjugate() * Vector3d(0, 0, w);
  return m;
}

// Hovering and turning to and fro. (In a steady turn a constant tilt could stand for a bias, for ever.)
Motion TurningToAndFro(double t_s) {
  constexpr double kAngle = 2, kFrequency = 0.4;
  Motion m{{HeadingRotation(kAngle * std::sin(kFrequency * t_s)), {3, 2, -6}}, kZero, kZero, kZero};
  m.w_B.z() = kAngle * kFrequency * std::cos(kFrequency * t_s);
  return m;
}

Path Still(const Pose& X_NB) {
  return [=](double) { return Motion{X_NB, kZero, kZero, kZero}; };
}

struct Errors {
  double position_m = 0, velocity_m_s = 0, tilt_deg = 0, yaw_deg = 0, rate_rad_s = 0;
};

Errors ErrorsOf(const StateEstimator& estimator, const Motion& truth) {
  const Vector3d down_B = truth.X_NB.R.conjugate() * Vector3d::UnitZ();
  const Vector3d down_E = estimator.X_NB().R.conjugate() * Vector3d::UnitZ();
  return {(estimator.X_NB().p - truth.X_NB.p).norm(), (estimator.v_N() - truth.v_N).norm(),
          Degrees(std::acos(std::min(1.0, down_B.dot(down_E)))),
          Degrees(WrapAngle(YawOf(estimator.X_NB().R) - YawOf(truth.X_NB.R))),
          (estimator.w_B() - truth.w_B).norm()};
}

// Flies a path; returns the greatest errors after a time. What the IMU says is the mean of each step, as of a
// sensor that integrates.
Errors Fly(StateEstimator& estimator, Sensors& sensors, const Path& path, double duration_s,
           double judged_from_s) {
  Errors worst;
  const auto steps = std::lround(duration_s / kDt);
  for (long i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) * kDt;
    const Motion middle = path(t - kDt / 2), end = path(t);
    estimator.Step(kDt, sensors.Read(kDt, end.X_NB, end.v_N, middle.w_B,
                                     middle.X_NB.R.conjugate() * (middle.a_N - Vector3d(0, 0, kGravity))));
    if (t < judged_from_s) continue;
    const Errors e = ErrorsOf(estimator, end);
    worst.position_m = std::max(worst.position_m, e.position_m);
    worst.velocity_m_s = std::max(worst.velocity_m_s, e.velocity_m_s);
    worst.tilt_deg = std::max(worst.tilt_deg, e.tilt_deg);
    worst.yaw_deg = std::max(worst.yaw_deg, std::abs(e.yaw_deg));
    worst.rate_rad_s = std::max(worst.rate_rad_s, e.rate_rad_s);
  }
  return worst;
}

TEST(StateEstimator, WithPerfectSensorsItFollowsABankedCircle) {
  Sensors sensors(PerfectSensors(), 1);
  const Motion start = BankedCircle(0);
  StateEstimator estimator({}, start.X_NB, start.v_N, kZero);
  const Errors worst = Fly(estimator, sensors, BankedCircle, 40, 0);
  EXPECT_LT(worst.position_m, 0.02);
  EXPECT_LT(worst.velocity_m_s, 0.01);
  EXPECT_LT(worst.tilt_deg, 0.05);
  EXPECT_LT(worst.yaw_deg, 0.05);
  EXPECT_LT(worst.rate_rad_s, 1e-3);
}

TEST(StateEstimator, ToldThatItsSensorsArePerfectItStaysANumber) {
  Sensors sensors(PerfectSensors(), 1);
  const Motion start = BankedCircle(0);
  StateEstimator estimator(PerfectSensors(), start.X_NB, start.v_N, kZero);
  const Errors worst = Fly(estimator, sensors, BankedCircle, 40, 0);
  EXPECT_LT(worst.position_m, 0.05);
  EXPECT_LT(worst.tilt_deg, 0.1);
  EXPECT_TRUE(estimator.X_NB().p.allFinite());
  EXPECT_TRUE(estimator.X_NB().R.coeffs().allFinite());
}

TEST(StateEstimator, WithThePublishedSensorsItsErrorsAreThoseOfSuchAnAutopilot) {
  double position = 0, velocity = 0, tilt = 0, yaw = 0;
  constexpr int kSeeds = 12;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Sensors sensors({}, seed);
    const Motion start = BankedCircle(0);
    Vector3d bias = kZero;  // as averaged at rest before the flight
    Sensors at_rest = sensors;
    for (int i = 0; i < 1000; ++i)
      bias += at_rest.Read(kDt, {}, kZero, kZero, {0, 0, -kGravity}).imu.w_B / 1000;
    StateEstimator estimator({}, start.X_NB, start.v_N, bias);
    Fly(estimator, sensors, BankedCircle, 30, 30);
    const Errors e = Fly(
        estimator, sensors, [](double t) { return BankedCircle(t + 30); }, 30, 0);
    EXPECT_LT(e.position_m, 8) << seed;
    EXPECT_LT(e.velocity_m_s, 0.6) << seed;
    EXPECT_LT(e.tilt_deg, 3) << seed;
    EXPECT_LT(e.yaw_deg, 6) << seed;
    position += e.position_m / kSeeds, velocity += e.velocity_m_s / kSeeds;
    tilt += e.tilt_deg / kSeeds, yaw += e.yaw_deg / kSeeds;
  }
  // on the mean over the seeds: neither the truth in disguise nor worse than its sensors
  EXPECT_GT(position, 0.2);
  EXPECT_LT(position, 3);
  EXPECT_GT(velocity, 0.02);
  EXPECT_LT(velocity, 0.3);
  EXPECT_GT(tilt, 0.05);
  EXPECT_LT(tilt, 1.5);
  EXPECT_GT(yaw, 0.1);
  EXPECT_LT(yaw, 3);
}

TEST(StateEstimator, LearnsTheBiasOfTheGyroscopesInTurns) {
  SensorParameters p = PerfectSensors();
  p.gyro_turn_on_rad_s = 0.001;
  Sensors sensors(p, 5);
  StateEstimator estimator({}, TurningToAndFro(0).X_NB, kZero, kZero);  // which knows nothing of the bias
  const double before = Fly(estimator, sensors, TurningToAndFro, 1, 0).rate_rad_s;
  const double after = Fly(
                           estimator, sensors, [](double t) { return TurningToAndFro(t + 1); }, 90, 80)
                           .rate_rad_s;
  EXPECT_GT(before, 0.001);
  EXPECT_LT(after, before / 4);
}

TEST(StateEstimator, LearnsTheBiasOfTheAccelerometersInTurns) {
  SensorParameters p = PerfectSensors();
  p.accelerometer_turn_on_m_s2 = 0.196;
  double early = 0, late = 0;
  constexpr int kSeeds = 5;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Sensors sensors(p, seed);
    StateEstimator estimator({}, TurningToAndFro(0).X_NB, kZero, kZero);
    early += Fly(estimator, sensors, TurningToAndFro, 10, 2).tilt_deg / kSeeds;
    late += Fly(
                estimator, sensors, [](double t) { return TurningToAndFro(t + 10); }, 60, 55)
                .tilt_deg /
            kSeeds;
  }
  EXPECT_GT(early, 0.2);  // of the degree or more that such a bias is worth
  EXPECT_LT(late, early / 4);
}

TEST(StateEstimator, FindsItsYawByTheCompass) {
  for (const double yaw_deg : {35.0, -130.0, 170.0}) {
    for (const double error_deg : {10.0, -10.0}) {
      const Pose X_NB{HeadingRotation(Radians(yaw_deg)), {1, 2, -3}};
      Sensors sensors(PerfectSensors(), 1);
      const Pose believed{HeadingRotation(Radians(yaw_deg + error_deg)), X_NB.p};
      StateEstimator estimator({}, believed, kZero, kZero);
      Fly(estimator, sensors, Still(X_NB), 0.5, 0);
      EXPECT_LT(std::abs(ErrorsOf(estimator, Still(X_NB)(0)).yaw_deg), 2) << yaw_deg << ' ' << error_deg;
      Fly(estimator, sensors, Still(X_NB), 20, 0);
      EXPECT_LT(std::abs(ErrorsOf(estimator, Still(X_NB)(0)).yaw_deg), 0.3) << yaw_deg << ' ' << error_deg;
    }
  }
}

TEST(StateEstimator, FindsItsPlaceByGpsAndItsHeightByTheBarometer) {
  const Pose X_NB{HeadingRotation(Radians(70)), {4, -2, -9}};
  Sensors sensors(PerfectSensors(), 1);
  StateEstimator estimator({}, {X_NB.R, X_NB.p + Vector3d(0.5, -0.3, 0.4)}, {0.1, -0.1, 0.2}, kZero);
  Fly(estimator, sensors, Still(X_NB), 60, 0);
  EXPECT_LT((estimator.X_NB().p - X_NB.p).norm(), 0.1);
  EXPECT_LT(estimator.v_N().norm(), 0.02);
}

}  // namespace
}  // namespace kestrel::sim
