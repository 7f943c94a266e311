// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/rotor_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/sensor/heading_gyro.h"

namespace kestrel::sim {
namespace {

constexpr double kDt = 0.002;

// What a rotor takes: torque that goes with the square of its speed.
double Load(const DriveParameters& p, const DriveState& s, double power_w) {
  return power_w / p.speed_rad_s * std::pow(s.speed_rad_s / p.speed_rad_s, 2);
}

TEST(RotorDrive, SpoolsUpInItsTimeWithoutOverspeed) {
  const DriveParameters p;
  DriveState s;
  double highest = 0;
  for (double t = 0; t < p.spool_s + 1; t += kDt) {
    s = StepDrive(p, s, true, Load(p, s, 550), kDt);
    highest = std::max(highest, s.speed_rad_s);
    ASSERT_TRUE(t > 0.8 * p.spool_s || s.speed_rad_s < 0.9 * p.speed_rad_s) << t;
  }
  EXPECT_NEAR(s.speed_rad_s, p.speed_rad_s, 0.02 * p.speed_rad_s);
  EXPECT_LT(highest, 1.04 * p.speed_rad_s);
}

TEST(RotorDrive, GovernorBringsTheSpeedBackAfterAStepOfLoad) {
  const DriveParameters p;
  DriveState s;
  for (double t = 0; t < 20; t += kDt) s = StepDrive(p, s, true, Load(p, s, 1000), kDt);
  EXPECT_NEAR(s.speed_rad_s, p.speed_rad_s, 0.01);
  EXPECT_NEAR(s.power_w, 1000, 1);
  double lowest = s.speed_rad_s;
  for (double t = 0; t < 5; t += kDt) {
    s = StepDrive(p, s, true, Load(p, s, 1200), kDt);
    lowest = std::min(lowest, s.speed_rad_s);
  }
  EXPECT_LT(lowest, 0.995 * p.speed_rad_s);  // it droops, but not by much
  EXPECT_GT(lowest, 0.97 * p.speed_rad_s);
  EXPECT_NEAR(s.speed_rad_s, p.speed_rad_s, 0.002 * p.speed_rad_s);
}

TEST(RotorDrive, MoreThanItsPowerSlowsTheRotor) {
  const DriveParameters p;
  DriveState s{p.speed_rad_s, p.speed_rad_s, 0.7, 1000};
  for (double t = 0; t < 20; t += kDt) {
    s = StepDrive(p, s, true, Load(p, s, 2000), kDt);
    ASSERT_LE(s.power_w, p.power_w);
  }
  // where the load takes just what there is: 2000 (w / w0)^3 = 1400
  EXPECT_NEAR(s.speed_rad_s / p.speed_rad_s, std::cbrt(0.7), 0.005);
}

TEST(RotorDrive, PowerThatTheLoadDoesNotTakeIsInTheRotor) {
  const DriveParameters p;
  DriveState s{90, p.speed_rad_s, 0.7, 1000};
  double energy = 0;
  const double from = p.inertia_kg_m2 / 2 * s.speed_rad_s * s.speed_rad_s, dt = 1e-4;
  for (double t = 0; t < 1; t += dt) {
    const double load = Load(p, s, 700), before = s.speed_rad_s;
    s = StepDrive(p, s, true, load, dt);
    energy += dt * (s.power_w - load * before);
  }
  EXPECT_NEAR(p.inertia_kg_m2 / 2 * s.speed_rad_s * s.speed_rad_s - from, energy, 0.005 * energy);
}

TEST(RotorDrive, SwitchedOffItRunsDown) {
  const DriveParameters p;
  DriveState s{p.speed_rad_s, p.speed_rad_s, 0.7, 1000};
  for (double t = 0; t < 5; t += kDt) s = StepDrive(p, s, false, Load(p, s, 500), kDt);
  EXPECT_LT(s.power_w, 1);
  // w' = -c w^2 / I from w0: w = w0 / (1 + c w0 t / I), and a lag of 50 ms of the motor's power before
  const double c = 500 / std::pow(p.speed_rad_s, 3);
  EXPECT_NEAR(s.speed_rad_s, p.speed_rad_s / (1 + c * p.speed_rad_s * 5 / p.inertia_kg_m2), 1.5);
}

TEST(HeadingGyro, ItsIntegralHoldsAgainstASteadyTorqueAndStopsAtTheLimit) {
  const HeadingGyroParameters p;
  double rate = 0, angle = 0, integral = 0;
  for (double t = 0; t < 10; t += kDt) {
    const double pitch = HeadingGyro(p, 0 - rate, 0, -0.35, 0.45, kDt, integral);
    rate += kDt * (120 * pitch - 25);  // a tail rotor against a torque that asks for 0.21 rad
    angle += kDt * rate;
  }
  EXPECT_NEAR(rate, 0, 1e-3);
  EXPECT_NEAR(integral, 25.0 / 120, 1e-3);
  for (double t = 0; t < 10; t += kDt) HeadingGyro(p, 1, 0, -0.35, 0.45, kDt, integral);
  EXPECT_LT(integral, 0.4501);
  EXPECT_LT(HeadingGyro(p, -1, 0, -0.35, 0.45, kDt, integral), 0.4);  // nothing to unwind
}

}  // namespace
}  // namespace kestrel::sim
