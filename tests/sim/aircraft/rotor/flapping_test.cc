// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/flapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/aircraft/helicopters.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSpeed = 125;

FlappingState After(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                    const FlappingInput& input, double duration_s) {
  FlappingState state;
  for (double t = 0; t < duration_s - 1e-9; t += 0.001)
    state = StepFlapping(rotor, p, spin, kSpeed, state, input, 0.001);
  return state;
}

// One blade as a rod that is hinged at the shaft, on its way round: the flapping equation in the rotating
// frame, from the acceleration of its points. Returns the tilt of the disc that it draws in the end.
Vector2d TiltOfABlade(const PitchedRotorParameters& rotor, const FlappingParameters& p, Spin spin,
                      const FlappingInput& in) {
  const double I = p.blade_inertia_kg_m2, s = static_cast<int>(spin), W = in.speed_rad_s;
  const double lock =
      kAirDensity * rotor.lift_slope_per_rad * rotor.chord_m * std::pow(rotor.radius_m, 4) / I;
  const double spring = p.hub_stiffness_n_m / (rotor.blades / 2.0);
  const Vector3d axis(0, 0, s * W);  // of the shaft's rotation, in B
  const auto flap_acceleration = [&](double azimuth, double flap, double rate) {
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0), down(0, 0, 1);
    const Vector3d e = std::cos(flap) * out - std::sin(flap) * down;
    const Vector3d up = -std::sin(flap) * out - std::cos(flap) * down;
    const Vector3d w = in.w_B + axis, w_dot = in.w_B.cross(axis);
    // pitched so that without a spring the disc tilts by the cyclic, a quarter of a turn later
    const double pitch = -s * (in.cyclic.x() * std::sin(azimuth) + in.cyclic.y() * std::cos(azimuth));
    const double air = lock / 8 * W * W * (pitch - (rate + in.w_B.cross(e).dot(up)) / W);
    return air - spring / I * flap - (w_dot.cross(e) + w.cross(w.cross(e))).dot(up);
  };
  double flap = 0, rate = 0, azimuth = 0;
  Vector2d tilt = Vector2d::Zero();
  constexpr int kTurns = 40, kSteps = 4000;
  for (int i = 0; i < kTurns * kSteps; ++i) {  // the midpoint rule
    const double h = 2 * std::numbers::pi / kSteps / W;
    const double half_rate = rate + h / 2 * flap_acceleration(azimuth, flap, rate);
    const double half_flap = flap + h / 2 * rate, half_azimuth = azimuth + h / 2 * s * W;
    flap += h * half_rate;
    rate += h * flap_acceleration(half_azimuth, half_flap, half_rate);
    azimuth = half_azimuth + h / 2 * s * W;
    if (i >= (kTurns - 1) * kSteps)  // flap = a cos - b sin
      tilt += 2.0 / kSteps * flap * Vector2d(std::cos(azimuth), -std::sin(azimuth));
  }
  return tilt;
}

TEST(Flapping, ComesToRestWhereABladeDoesThatIsFollowedRound) {
  const PitchedRotorParameters rotor;
  FlappingParameters p;
  p.bar_mixing = 0;
  for (const Spin spin : {Spin::kClockwise, Spin::kCounterclockwise}) {
    for (const auto& [cyclic, w_B] :
         {std::pair(Vector2d(0.05, 0), Vector3d(0, 0, 0)), std::pair(Vector2d(0, 0.05), Vector3d(0, 0, 0)),
          std::pair(Vector2d(0, 0), Vector3d(0.4, 0, 0)), std::pair(Vector2d(0, 0), Vector3d(0, 0.4, 0))}) {
      FlappingInput in;
      in.cyclic = cyclic, in.w_B = w_B, in.speed_rad_s = kSpeed;
      const Vector2d of_a_blade = TiltOfABlade(rotor, p, spin, in);
      const Vector2d tilt = After(rotor, p, spin, in, 2).disc;
      ASSERT_GT(of_a_blade.norm(), 0.01);
      EXPECT_LT((tilt - of_a_blade).norm(), 0.01 * of_a_blade.norm())
          << static_cast<int>(spin) << " cyclic " << cyclic.transpose() << " rate " << w_B.transpose() << ": "
          << tilt.transpose() << " is not " << of_a_blade.transpose();
    }
  }
}

TEST(Flapping, TimeConstantIsSixteenOverLockNumberAndSpeed) {
  const PitchedRotorParameters rotor{0.88, 2, 0.06, 5.5, 0.024, 0.005};
  FlappingParameters p;
  p.bar_mixing = p.hub_stiffness_n_m = 0;
  const double lock = 1.225 * 5.5 * 0.06 * std::pow(0.88, 4) / p.blade_inertia_kg_m2;
  const double time = 16 / (lock * kSpeed);
  FlappingInput in;
  in.speed_rad_s = kSpeed;
  in.cyclic = {0.05, -0.03};
  FlappingState state;
  for (int i = 0; i < 1000; ++i)
    state = StepFlapping(rotor, p, Spin::kClockwise, kSpeed, state, in, time / 1000);
  EXPECT_LT((state.disc - (1 - std::exp(-1)) * in.cyclic).norm(), 1e-5);
  FlappingState coarse;  // 2 ms are fine enough
  for (double t = 0; t < time; t += 0.002)
    coarse = StepFlapping(rotor, p, Spin::kClockwise, kSpeed, coarse, in, 0.002);
  EXPECT_LT((coarse.disc - (1 - std::exp(-std::ceil(time / 0.002) * 0.002 / time)) * in.cyclic).norm(), 1e-4);
}

// A second at 0.5 rad/s of roll.
FlappingState XCellAfterRolling() {
  const HelicopterParameters x = XCell();
  FlappingInput in;
  in.speed_rad_s = 167;
  in.w_B = {0.5, 0, 0};
  FlappingState state;
  for (int i = 0; i < 1000; ++i)
    state = StepFlapping(x.rotor, x.flapping, Spin::kClockwise, 167, state, in, 0.001);
  return state;
}

TEST(Flapping, TheBarFollowsTheFuselageSlowly) {
  const FlappingState state = XCellAfterRolling();
  EXPECT_NEAR(state.bar.y(), -16 / (0.8 * 167) * 0.5, 1e-4);
  EXPECT_NEAR(state.bar.x(), 0, 1e-9);
}

// Gavrilets sees rotor and bar as one lag of 16 / (Lock number of the bar, 0.8, times 167 rad/s) = 0.12 s.
TEST(Flapping, RotorAndBarTogetherLagAsTheXCellsDo) {
  const FlappingState state = XCellAfterRolling();
  EXPECT_NEAR(-state.disc.y() / 0.5, 16 / (0.8 * 167), 0.15 * 0.12);
}

TEST(Flapping, TheDiscIsBlownAwayFromWhereItFlies) {
  const PitchedRotorParameters rotor;
  const FlappingParameters p;
  FlappingInput in;
  in.speed_rad_s = kSpeed, in.collective = 0.12, in.through_m_s = 4;
  in.v_B = {8, 0, 0};
  const Vector2d forward = After(rotor, p, Spin::kClockwise, in, 1).disc;
  in.v_B = {0, 8, 0};
  const Vector2d right = After(rotor, p, Spin::kClockwise, in, 1).disc;
  const double U = kSpeed * rotor.radius_m, textbook = 2 * 8 / U * (4.0 / 3 * 0.12 - 4 / U);
  EXPECT_NEAR(forward.x(), 0.2 * textbook, 0.03 * textbook);  // back
  EXPECT_NEAR(right.y(), -0.2 * textbook, 0.03 * textbook);   // left
}

}  // namespace
}  // namespace kestrel::sim
