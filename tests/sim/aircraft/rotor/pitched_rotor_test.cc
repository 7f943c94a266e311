// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/rotor/pitched_rotor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/aircraft/rotor/rotor.h"

namespace kestrel::sim {
namespace {

constexpr double kSpeed = 125;
constexpr double kThrust = 93;

double Area(const PitchedRotorParameters& p) { return std::numbers::pi * p.radius_m * p.radius_m; }

// The induced velocity that comes to rest.
double Settled(const PitchedRotorParameters& p, double pitch, const RotorFlow& flow) {
  double v = 1;
  for (int i = 0; i < 2000; ++i) v = StepInduced(p, kSpeed, pitch, v, flow, 0.002);
  return v;
}

TEST(PitchedRotor, HoversWhereBladesAndMomentumAgree) {
  const PitchedRotorParameters p;
  const double v = SteadyInduced(p, kThrust, 0), pitch = PitchFor(p, kSpeed, kThrust, 0);
  EXPECT_NEAR(2 * 0.9 * kAirDensity * Area(p) * v * v, kThrust, 1e-9);
  EXPECT_NEAR(LoadsOf(p, kSpeed, pitch, v, {}).thrust_n, kThrust, 1e-9);
  EXPECT_NEAR(Settled(p, pitch, {}), v, 1e-9);
}

TEST(PitchedRotor, ClimbsWhereBladesAndMomentumAgree) {
  const PitchedRotorParameters p;
  for (const double climb : {-1.0, 2.0}) {
    const RotorFlow flow{0, climb};
    const double pitch = PitchFor(p, kSpeed, kThrust, climb), v = Settled(p, pitch, flow);
    EXPECT_NEAR(2 * 0.9 * kAirDensity * Area(p) * v * (v + climb), kThrust, 1e-6) << climb;
    EXPECT_NEAR(LoadsOf(p, kSpeed, pitch, v, flow).thrust_n, kThrust, 1e-6) << climb;
  }
  EXPECT_GT(PitchFor(p, kSpeed, kThrust, 2), PitchFor(p, kSpeed, kThrust, -1));
}

TEST(PitchedRotor, FlyingForwardFindsMoreAirToPushOn) {
  const PitchedRotorParameters p;
  const double pitch = PitchFor(p, kSpeed, kThrust, 0), V = 15;
  const RotorFlow flow{V, 0};
  const double v = Settled(p, pitch, flow), thrust = LoadsOf(p, kSpeed, pitch, v, flow).thrust_n;
  EXPECT_GT(thrust, 1.1 * kThrust);
  EXPECT_NEAR(v, thrust / (2 * 0.9 * kAirDensity * Area(p) * V), 0.03 * v);  // H. Glauert's limit for V >> v
}

// B. Mettler and others write the derivatives of heave as V. Gavrilets does: with l = v_i / (wR),
// Z_col = -8/3 rho (wR)^2 A a s l / (16 l + a s), Z_w = -2 rho wR A a s l / (16 l + a s), without losses of
// the wake.
TEST(PitchedRotor, HeaveDerivativesAreThePublishedOnes) {
  const PitchedRotorParameters p;
  const double U = kSpeed * p.radius_m, sa = 2 * p.chord_m / (std::numbers::pi * p.radius_m) * 5.5;
  const double pitch = PitchFor(p, kSpeed, kThrust, 0), l = SteadyInduced(p, kThrust, 0) / U;
  const auto thrust = [&](double at_pitch, double climb) {
    const RotorFlow flow{0, climb};
    return LoadsOf(p, kSpeed, at_pitch, Settled(p, at_pitch, flow), flow).thrust_n;
  };
  const double by_pitch = (thrust(pitch + 1e-4, 0) - thrust(pitch - 1e-4, 0)) / 2e-4;
  const double by_climb = (thrust(pitch, 1e-3) - thrust(pitch, -1e-3)) / 2e-3;
  const double shared = kAirDensity * U * Area(p) * sa * l / (16 * l + sa);
  EXPECT_NEAR(by_pitch / (8.0 / 3 * U * shared), 1, 0.05);
  EXPECT_NEAR(by_climb / (-2 * shared), 1, 0.05);
}

TEST(PitchedRotor, InflowLagsByTheApparentMassAndTheThrustOvershoots) {
  const PitchedRotorParameters p;
  const double pitch = PitchFor(p, kSpeed, kThrust, 0), more = PitchFor(p, kSpeed, 1.05 * kThrust, 0);
  const double from = SteadyInduced(p, kThrust, 0), to = SteadyInduced(p, 1.05 * kThrust, 0);
  EXPECT_GT(LoadsOf(p, kSpeed, more, from, {}).thrust_n, 1.06 * kThrust);
  // linearised about hover: m / (4 rho A k v + dT/dv)
  const double mass = 0.637 * kAirDensity * 4.0 / 3 * Area(p) * p.radius_m;
  const double slope =
      kAirDensity * 5.5 * 2 * p.chord_m / (std::numbers::pi * p.radius_m) * Area(p) * kSpeed * p.radius_m / 4;
  const double time = mass / (4 * 0.9 * kAirDensity * Area(p) * from + slope);
  double v = from, t = 0;
  for (; v < from + (1 - std::exp(-1)) * (to - from); t += 1e-4)
    v = StepInduced(p, kSpeed, more, v, {}, 1e-4);
  EXPECT_NEAR(t, time, 0.05 * time);
  EXPECT_NE(pitch, more);
}

TEST(PitchedRotor, TheInflowOfASmallRotorIsStableAtTheStepOfTheSimulation) {
  const PitchedRotorParameters tail{0.13, 2, 0.029, 5.0, 0.024, 0.05};
  double v = 0;
  for (int i = 0; i < 20; ++i) v = StepInduced(tail, 775, 0.2, v, {}, 0.002);
  const double thrust = LoadsOf(tail, 775, 0.2, v, {}).thrust_n;
  EXPECT_NEAR(v, SteadyInduced(tail, thrust, 0), 1e-3 * v);
}

// I. C. Cheeseman, W. E. Bennett: at equal power the thrust near the ground is 1 / (1 - (R / 4z)^2) times
// that away from it.
TEST(PitchedRotor, GroundEffectIsWhatItsDefinitionSays) {
  const PitchedRotorParameters p;
  const double away = SteadyInduced(p, kThrust, 0) * kThrust;  // induced power
  for (const double height : {0.6 * p.radius_m, p.radius_m, 2 * p.radius_m}) {
    const RotorFlow flow{0, 0, GroundEffect(p.radius_m, height)};
    const auto power = [&](double pitch) {
      const double v = Settled(p, pitch, flow);
      return LoadsOf(p, kSpeed, pitch, v, flow).thrust_n * VelocityThroughDisc(v, flow);
    };
    double low = 0, high = 0.3;
    for (int i = 0; i < 40; ++i) (power((low + high) / 2) < away ? low : high) = (low + high) / 2;
    const double thrust = LoadsOf(p, kSpeed, low, Settled(p, low, flow), flow).thrust_n;
    const double ratio = p.radius_m / (4 * height);
    EXPECT_NEAR(thrust / kThrust, 1 / (1 - ratio * ratio), 1e-6) << height;
  }
}

TEST(PitchedRotor, PowerIsThatOfTheAirAndOfTheBladesDrag) {
  const PitchedRotorParameters p;
  const double v = SteadyInduced(p, kThrust, 0), U = kSpeed * p.radius_m;
  const RotorLoads loads = LoadsOf(p, kSpeed, PitchFor(p, kSpeed, kThrust, 0), v, {});
  const double profile =
      2 * p.chord_m * p.radius_m * kAirDensity / 8 * p.drag_coefficient * U * U * U;  // of two blades
  EXPECT_NEAR(loads.torque_n_m * kSpeed, kThrust * v + profile, 1e-6 * kThrust * v);
  const double ideal = kThrust * std::sqrt(kThrust / (2 * kAirDensity * Area(p)));
  const double merit = ideal / (loads.torque_n_m * kSpeed);
  EXPECT_GT(merit, 0.35);  // small rotors: less than the 0.6 to 0.8 of large ones
  EXPECT_LT(merit, 0.7);
}

TEST(PitchedRotor, ThrustEndsAtTheStallEitherWayAndAStandingRotorHasNone) {
  const PitchedRotorParameters p;
  const double most = p.max_thrust_coefficient * kAirDensity * Area(p) * std::pow(kSpeed * p.radius_m, 2);
  EXPECT_NEAR(LoadsOf(p, kSpeed, 1, 0, {}).thrust_n, most, 1e-9 * most);
  EXPECT_NEAR(LoadsOf(p, kSpeed, -1, 0, {}).thrust_n, -most, 1e-9 * most);
  EXPECT_EQ(LoadsOf(p, 0, 0.2, 0, {}).thrust_n, 0);
  EXPECT_EQ(LoadsOf(p, 0, 0.2, 0, {}).torque_n_m, 0);
}

}  // namespace
}  // namespace kestrel::sim
