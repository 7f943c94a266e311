// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/rotor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

const RotorParameters kRotor;

// Thrust of a rotor of fixed pitch from momentum theory and blade elements, solved for the inflow by
// bisection; its pitch is the one with which it gives k_f w^2 at rest.
double ThrustByMomentumTheory(const RotorParameters& p, double w, double climb) {
  const double area = std::numbers::pi * p.radius_m * p.radius_m, tip = w * p.radius_m;
  const double rest = p.thrust_coefficient_n_s2 * w * w;
  const double induced = std::sqrt(rest / (2 * kAirDensity * area));
  const double unit = kAirDensity * area * tip * tip * p.solidity * p.lift_slope_per_rad / 4;
  const double pitch = rest / unit + induced / tip;  // 2/3 of theta
  double low = 0, high = 5 * induced;
  for (int i = 0; i < 200; ++i) {
    const double v = (low + high) / 2;
    const double momentum = 2 * kAirDensity * area * v * (v + climb);
    const double blades = unit * (pitch - (v + climb) / tip);
    (momentum < blades ? low : high) = v;
  }
  return 2 * kAirDensity * area * low * (low + climb);
}

TEST(Thrust, AtRestIsThrustCoefficientTimesSpeedSquared) {
  EXPECT_NEAR(Thrust(kRotor, 505, 0), 9.9865e-6 * 505 * 505, 1e-12);
  EXPECT_EQ(Thrust(kRotor, 0, 3), 0);
  EXPECT_NEAR(Thrust(kRotor, 838, 0), 7.01, 0.01);  // the figure of RotorS
}

TEST(Thrust, ClimbSlopeAtHoverIsThatOfMomentumTheory) {
  for (const double w : {300.0, 505.0, 838.0}) {
    const double h = 1e-3;
    const double by_theory =
        (ThrustByMomentumTheory(kRotor, w, h) - ThrustByMomentumTheory(kRotor, w, -h)) / (2 * h);
    const double slope = (Thrust(kRotor, w, h) - Thrust(kRotor, w, -h)) / (2 * h);
    EXPECT_LT(slope, 0);
    EXPECT_NEAR(slope, by_theory, 1e-5 * std::abs(by_theory)) << w;
  }
}

TEST(Thrust, StaysCloseToMomentumTheoryInClimbsAndDescentsOfASmallAircraft) {
  for (const double climb : {-2.0, -1.0, 1.0, 2.0}) {
    const double by_theory = ThrustByMomentumTheory(kRotor, 505, climb);
    EXPECT_NEAR(Thrust(kRotor, 505, climb), by_theory, 0.03 * by_theory) << climb;
  }
}

TEST(Thrust, IsNeverNegative) { EXPECT_EQ(Thrust(kRotor, 50, 20), 0); }

TEST(Rotor, ReactionTurnsTheAircraftAgainstTheSpin) {
  const double reaction = 0.016 * 9.9865e-6 * 500 * 500;
  // z of B is down: a positive torque about it turns the aircraft clockwise seen from above
  EXPECT_NEAR(RotorWrench(kRotor, 500, Spin::kClockwise, {0, 0, 0}).torque.z(), -reaction, 1e-15);
  EXPECT_NEAR(RotorWrench(kRotor, 500, Spin::kCounterclockwise, {0, 0, 0}).torque.z(), reaction, 1e-15);
}

TEST(Rotor, DragLiesInTheDiscOpposesTheMotionAndHasItsClosedForm) {
  const Vector3d v_B(3, -4, 2);
  for (const Spin spin : {Spin::kClockwise, Spin::kCounterclockwise}) {
    const Wrench moving = RotorWrench(kRotor, 500, spin, v_B);
    const Wrench axial = RotorWrench(kRotor, 500, spin, {0, 0, 2});
    const Vector3d force = moving.force - axial.force, torque = moving.torque - axial.torque;
    EXPECT_LT((force - Vector3d(-3, 4, 0) * 500 * 8.06428e-5).norm(), 1e-15);
    EXPECT_LT((torque - Vector3d(-3, 4, 0) * 500 * 1e-6).norm(), 1e-15);
    EXPECT_LT(force.dot(v_B), 0);
  }
  EXPECT_EQ(RotorWrench(kRotor, 0, Spin::kClockwise, v_B).force.norm(), 0);
}

TEST(Rotor, ThrustPointsUpAndSinkingRaisesIt) {
  const double rest = RotorWrench(kRotor, 500, Spin::kClockwise, {0, 0, 0}).force.z();
  EXPECT_NEAR(rest, -Thrust(kRotor, 500, 0), 1e-15);
  EXPECT_LT(RotorWrench(kRotor, 500, Spin::kClockwise, {0, 0, 1}).force.z(), rest);   // down
  EXPECT_GT(RotorWrench(kRotor, 500, Spin::kClockwise, {0, 0, -1}).force.z(), rest);  // up
  EXPECT_NEAR(RotorWrench(kRotor, 500, Spin::kClockwise, {0, 0, 0}, 1.2).force.z(), 1.2 * rest, 1e-14);
}

TEST(GroundEffect, IsCheesemanBennettDownToHalfARadius) {
  EXPECT_NEAR(GroundEffect(0.128, 0.128), 16.0 / 15, 1e-14);
  EXPECT_NEAR(GroundEffect(0.128, 0.064), 4.0 / 3, 1e-14);
  EXPECT_NEAR(GroundEffect(0.128, 0.256), 64.0 / 63, 1e-14);
  EXPECT_NEAR(GroundEffect(0.128, 100), 1, 1e-6);
  for (const double height_m : {0.05, 0.032, 0.0, -1.0})
    EXPECT_NEAR(GroundEffect(0.128, height_m), 4.0 / 3, 1e-14);
  for (double z = 0.07; z < 1; z += 0.01) EXPECT_GT(GroundEffect(0.128, z), GroundEffect(0.128, z + 0.01));
}

TEST(Motor, StepResponseIsOneMinusExponentialUpAndDown) {
  double up = 0, down = 400;
  for (int i = 1; i <= 50; ++i) {
    up = StepMotor(kRotor, up, 400, 0.002);
    down = StepMotor(kRotor, down, 0, 0.002);
    EXPECT_NEAR(up, 400 * (1 - std::exp(-i * 0.002 / 0.0125)), 1e-10);
    EXPECT_NEAR(down, 400 * std::exp(-i * 0.002 / 0.025), 1e-10);
  }
}

TEST(Motor, ResponseDoesNotDependOnTheStepSize) {
  double fine = 100;
  for (int i = 0; i < 10; ++i) fine = StepMotor(kRotor, fine, 300, 0.001);
  EXPECT_NEAR(StepMotor(kRotor, 100, 300, 0.01), fine, 1e-10);
  EXPECT_EQ(StepMotor(kRotor, 250, 250, 0.01), 250);
}

}  // namespace
}  // namespace kestrel::sim
