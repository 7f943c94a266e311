// SPDX-License-Identifier: Apache-2.0
#include "control/margin/loop_margins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kestrel::control {
namespace {

// The answer of a lag of first order after a dead time.
VelocityStep Answer(double lag_s, double delay_s) {
  VelocityStep step{0.004, {}};
  for (double t_s = 0; t_s < 12; t_s += step.dt_s) {
    const double since_s = t_s - delay_s;
    step.answer.push_back(since_s <= 0 ? 0 : lag_s > 0 ? 1 - std::exp(-since_s / lag_s) : 1);
  }
  return step;
}

LoopMargins Of(double lag_s, double delay_s, const ServoLoop& loop) {
  const VelocityStep answer = Answer(lag_s, delay_s);
  return Margins([&](double w) { return OpenLoop(answer, loop, w); });
}

// lambda exp(-s tau) / s: gain 1 at w = lambda, phase -pi/2 - w tau, which is -pi at w = pi / (2 tau).
TEST(LoopMargins, OfADeadTimeTheyAreThoseOfTheClosedForm) {
  for (const auto& [lambda, tau] : {std::pair(0.9, 0.85), {2.0, 0.3}, {1.3, 0.5}}) {
    const LoopMargins margins = Of(0, tau, {lambda});
    EXPECT_NEAR(margins.crossover_rad_s, lambda, 1e-3 * lambda);
    EXPECT_NEAR(margins.phase_deg, 90 - lambda * tau * 180 / M_PI, 0.3);
    EXPECT_NEAR(margins.delay_s, M_PI / 2 / lambda - tau, 0.003);
    EXPECT_NEAR(margins.gain, M_PI / 2 / tau / lambda, 0.03);
  }
}

// lambda exp(-s tau) / (s (1 + s T)): gain 1 where w^2 (1 + w^2 T^2) = lambda^2; phase -pi where tan(w tau) w T = 1.
TEST(LoopMargins, OfALagAfterADeadTimeTheyAreThoseOfTheClosedForm) {
  for (const auto& [lambda, T, tau] : {std::tuple(1.0, 0.4, 0.3), {0.8, 0.9, 0.1}, {2.5, 0.2, 0.15}}) {
    const double w = std::sqrt((std::sqrt(1 + 4 * lambda * lambda * T * T) - 1) / (2 * T * T));
    const double phase = M_PI / 2 - std::atan(w * T) - w * tau;
    double low = 0, high = M_PI / 2 / tau;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (std::tan(middle * tau) * middle * T < 1 ? low : high) = middle;
    }
    const LoopMargins margins = Of(T, tau, {lambda});
    EXPECT_NEAR(margins.crossover_rad_s, w, 2e-3 * w);
    EXPECT_NEAR(margins.phase_deg, phase * 180 / M_PI, 0.3);
    EXPECT_NEAR(margins.delay_s, phase / w, 0.004);
    EXPECT_NEAR(margins.gain, low * std::hypot(1, low * T) / lambda, 0.02);
  }
}

TEST(LoopMargins, ALoopThatSwingsHasNone) {
  const LoopMargins margins = Of(0, 1.2, {2.0});
  EXPECT_LT(margins.gain, 1);
  EXPECT_LT(margins.phase_deg, 0);
  EXPECT_LT(margins.delay_s, 0);
}

// With the dead time reckoned with exactly the characteristic equation is 1 + lambda / s, that of none; a loop
// that swings without settles with.
TEST(LoopMargins, ReckoningWithTheLatenessTakesItOutOfTheLoop) {
  const LoopMargins blind = Of(0, 1.0, {2.0});
  const LoopMargins seeing = Of(0, 1.0, {2.0, 1.0});
  EXPECT_LT(blind.phase_deg, 0);
  EXPECT_GT(seeing.phase_deg, 45);
  EXPECT_GT(seeing.gain, 1.8);
  const VelocityStep answer = Answer(0, 1.0);
  for (const double w : {0.3, 1.0, 2.5}) {
    const std::complex<double> s(0, w), L = OpenLoop(answer, {2.0, 1.0}, w);
    EXPECT_LT(std::abs(L / (1.0 + L) - 2.0 * std::exp(-s) / (s + 2.0)), 0.01) << w;
  }
}

// Whether the place comes to rest, of the loop flown in time: an autopilot of first order after a dead time, that
// answers with a gain, and a law that reckons with a lateness.
bool Settles(double lag_s, double delay_s, double gain, double lambda, double reckoned_s) {
  constexpr double kStep_s = 0.005;
  const auto late = static_cast<std::size_t>(std::lround(delay_s / kStep_s));
  const auto reckoned = static_cast<std::size_t>(std::lround(reckoned_s / kStep_s));
  std::vector<double> given;
  double p = 1, v = 0, to_come = 0, early = 0, end = 0;
  for (int i = 0; i < 16000; ++i) {
    given.push_back(-lambda * (p + to_come));
    to_come += kStep_s * given.back();
    if (given.size() > reckoned) to_come -= kStep_s * given[given.size() - 1 - reckoned];
    const double answered = given.size() > late ? given[given.size() - 1 - late] : 0;
    v += kStep_s / lag_s * (gain * answered - v);
    p += kStep_s * v;
    if (i > 4000 && i < 6000) early = std::max(early, std::abs(p));
    if (i > 14000) end = std::max(end, std::abs(p));
  }
  return end < early;
}

// A loop that reckons with the lateness has a gain of 1 at several frequencies; flown, it swings just beyond its
// margins.
TEST(LoopMargins, OfALoopThatReckonsTheyAreThoseAtWhichItSwings) {
  for (const auto& [lambda, T, tau] : {std::tuple(2.06, 0.3, 0.85), {0.9, 0.3, 0.85}, {1.5, 0.5, 0.4}}) {
    const LoopMargins margins = Of(T, tau, {lambda, T + tau});
    ASSERT_GT(margins.gain, 1.2) << lambda;
    ASSERT_GT(margins.delay_s, 0.1) << lambda;
    EXPECT_TRUE(Settles(T, tau + 0.93 * margins.delay_s, 1, lambda, T + tau)) << lambda;
    EXPECT_FALSE(Settles(T, tau + 1.07 * margins.delay_s, 1, lambda, T + tau)) << lambda;
    EXPECT_TRUE(Settles(T, tau, 0.95 * margins.gain, lambda, T + tau)) << lambda;
    EXPECT_FALSE(Settles(T, tau, 1.05 * margins.gain, lambda, T + tau)) << lambda;
  }
}

TEST(LoopMargins, AHeldCommandIsLateByHalfOfItsTime) {
  const LoopMargins held = Of(0, 0.4, {1.0, 0, 0.2});
  EXPECT_NEAR(held.phase_deg, 90 - 0.5 * 180 / M_PI, 0.4);
  EXPECT_NEAR(Answer(0.4, 0.3).Late_s(), 0.7, 0.002);
}

}  // namespace
}  // namespace kestrel::control
