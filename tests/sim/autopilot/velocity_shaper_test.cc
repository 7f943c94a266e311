// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/velocity_shaper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kestrel::sim {
namespace {

constexpr double kStep_s = 0.002;

// What becomes of a velocity that is asked for from time 0 on, at each step's end.
std::vector<VelocityShaper<1>::Shaped> Asked(double velocity, const ShaperLimits& limits, double duration_s) {
  VelocityShaper<1> shaper;
  std::vector<VelocityShaper<1>::Shaped> shaped;
  for (int i = 1; i * kStep_s <= duration_s; ++i)
    shaped.push_back(
        shaper.Step(i * kStep_s, kStep_s, VelocityShaper<1>::Vector(i == 1 ? 0.0 : velocity), limits));
  return shaped;
}

double At(const std::vector<VelocityShaper<1>::Shaped>& shaped, double t_s) {
  return shaped[static_cast<std::size_t>(std::lround(t_s / kStep_s))].velocity[0];
}

TEST(VelocityShaper, WithoutLimitsItGivesWhatIsAskedFor) {
  const auto shaped = Asked(1.5, {}, 0.1);
  for (std::size_t i = 1; i < shaped.size(); ++i) {
    EXPECT_EQ(shaped[i].velocity[0], 1.5);
    EXPECT_EQ(shaped[i].acceleration[0], 0);
  }
}

TEST(VelocityShaper, ADeadTimeShiftsIt) {
  const auto shaped = Asked(1.5, {.delay_s = 0.3}, 1);
  EXPECT_EQ(At(shaped, 0.296), 0);
  EXPECT_EQ(At(shaped, 0.304), 1.5);
}

// The closed form of a trapezoid of acceleration: for a change v it takes v / a, and a / j more with a jerk j.
TEST(VelocityShaper, TheVelocityIsThatOfTheLimits) {
  const auto slewed = Asked(-2, {.acceleration_m_s2 = 1.6}, 3);
  for (const double t_s : {0.2, 0.7, 1.2}) EXPECT_NEAR(At(slewed, t_s), -1.6 * t_s, 0.01) << t_s;
  EXPECT_EQ(At(slewed, 1.3), -2);

  const double a = 1.6, j = 4;
  const auto curved = Asked(2, {.acceleration_m_s2 = a, .jerk_m_s3 = j}, 4);
  for (const double t_s : {0.1, 0.2, 0.4}) EXPECT_NEAR(At(curved, t_s), j * t_s * t_s / 2, 0.01) << t_s;
  for (const double t_s : {0.6, 0.9}) EXPECT_NEAR(At(curved, t_s), a * (t_s - a / j / 2), 0.01) << t_s;
  EXPECT_NEAR(At(curved, 2 / a + a / j), 2, 0.2);  // proportional near the goal: a little later
  EXPECT_NEAR(At(curved, 3.5), 2, 2e-3);
}

TEST(VelocityShaper, NoStepGoesBeyondALimitOrPastTheGoal) {
  const double a = 1, j = 5;
  for (const double goal : {0.05, 0.3, 2.0}) {
    double before = 0;
    for (const auto& each : Asked(goal, {.delay_s = 0.1, .acceleration_m_s2 = a, .jerk_m_s3 = j}, 5)) {
      EXPECT_LE(std::abs(each.acceleration[0]), a * (1 + 1e-12));
      EXPECT_LE(std::abs(each.acceleration[0] - before), j * kStep_s * (1 + 1e-9));
      EXPECT_LE(each.velocity[0], goal * 1.02) << goal;
      before = each.acceleration[0];
    }
  }
}

TEST(VelocityShaper, TwoAxesAreLimitedAlongTheirSum) {
  VelocityShaper<2> shaper;
  const Eigen::Vector2d asked(3, -4);
  for (int i = 1; i <= 100; ++i) {
    const auto shaped = shaper.Step(i * kStep_s, kStep_s, asked, {.acceleration_m_s2 = 2});
    EXPECT_NEAR(shaped.acceleration.norm(), 2, 1e-9);
    EXPECT_NEAR(shaped.velocity.norm(), 2 * i * kStep_s, 1e-9);
    EXPECT_NEAR(shaped.velocity.x() * asked.y(), shaped.velocity.y() * asked.x(), 1e-12);
  }
}

}  // namespace
}  // namespace kestrel::sim
