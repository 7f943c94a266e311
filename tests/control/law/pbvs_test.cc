// SPDX-License-Identifier: Apache-2.0
#include "control/law/pbvs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

// The frame C moves for a short time with a constant twist, given in C.
Pose Moved(const Pose& X_DC, const Twist& twist, double dt_s) {
  return X_DC * Pose{ExpRotation(dt_s * twist.w), dt_s * twist.v};
}

Pose HeadingPose(const Vector3d& p_DH, double yaw_deg) { return {HeadingRotation(Radians(yaw_deg)), p_DH}; }

TEST(PbvsTwist, ErrorsFallExponentiallyAlongAStraightLineAndAboutAFixedAxis) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const double lambda = 0.8, dt = 1e-3;
  for (int i = 0; i < 20; ++i) {
    const Vector3d axis = Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    const double angle = 0.3 + 0.13 * i;  // to 160 degrees
    const Pose start{ExpRotation(angle * axis), {normal(rng), normal(rng), normal(rng)}};
    Pose X_DC = start;
    for (int step = 1; step <= 3000; ++step) {
      X_DC = Moved(X_DC, PbvsTwist(X_DC, lambda), dt);
      if (step % 500 != 0) continue;
      const double left = std::exp(-lambda * step * dt);
      // the integrator's own error is half of (lambda dt)^2 a step
      EXPECT_LT((X_DC.p - left * start.p).norm(), 1e-3 * start.p.norm());
      EXPECT_LT((LogRotation(X_DC.R) - left * angle * axis).norm(), 1e-3 * angle);
      EXPECT_LT(X_DC.p.cross(start.p).norm(), 1e-10);
      EXPECT_LT(LogRotation(X_DC.R).cross(axis).norm(), 1e-10);
    }
  }
}

TEST(PbvsTwist, IsNothingAtTheGoal) {
  const Twist twist = PbvsTwist({}, 2);
  EXPECT_EQ(twist.v, Vector3d::Zero());
  EXPECT_EQ(twist.w, Vector3d::Zero());
}

TEST(PbvsTargetTwist, TheTargetComesHomeOnAStraightLineInTheCameraAndTheTurnAboutAFixedAxis) {
  std::mt19937 rng(8);
  std::normal_distribution<double> normal;
  const double lambda = 0.8, dt = 1e-3;
  for (int i = 0; i < 20; ++i) {
    const Vector3d axis = Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    const double angle = 0.3 + 0.13 * i;
    const Pose X_DO{ExpRotation({0.2, -0.4, 0.1}), {0.1, -0.2, 2}};
    Pose X_CO = Pose{ExpRotation(angle * axis), {normal(rng), normal(rng), normal(rng)}}.Inverse() * X_DO;
    const Vector3d start = X_CO.p - X_DO.p;
    for (int step = 1; step <= 3000; ++step) {
      const Twist twist = PbvsTargetTwist(X_CO, X_DO, lambda);
      X_CO = Moved({}, twist, dt).Inverse() * X_CO;
      if (step % 500 != 0) continue;
      const double left = std::exp(-lambda * step * dt);
      // the integrator's own error, as above, with the lever of the target
      EXPECT_LT((X_CO.p - X_DO.p - left * start).norm(), 5e-3 * (start.norm() + X_DO.p.norm()));
      const Vector3d turn = LogRotation(X_DO.R * X_CO.R.conjugate());
      EXPECT_LT((turn - left * angle * axis).norm(), 1e-3 * angle);
    }
  }
}

TEST(RotationVectorInteraction, IsTheDerivativeByItsDefinition) {
  std::mt19937 rng(9);
  std::normal_distribution<double> normal;
  const double h = 1e-5;  // central differences: errors of h^2 and of the rounding over h, both near 1e-10
  for (const double angle : {0.0, 1e-9, 1e-4, 0.0099, 0.0101, 0.5, 1.5, 3.0}) {
    const Vector3d theta_u = angle * Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    const Eigen::Matrix3d L = RotationVectorInteraction(theta_u);
    for (int i = 0; i < 3; ++i) {
      const auto turned = [&](double by) -> Vector3d {
        return LogRotation(ExpRotation(theta_u) * ExpRotation(by * Vector3d::Unit(i)));
      };
      EXPECT_LT((L.col(i) - (turned(h) - turned(-h)) / (2 * h)).norm(), 1e-8) << angle;
    }
  }
}

TEST(ServoSetpoint, NorthOfTheGoalFacingEastItFliesToItsRightAndTurnsBackToTheLeft) {
  const VelocitySetpoint setpoint =
      ServoSetpoint(HeadingPose({1, 0, 0}, 90), {.lambda_per_s = 0.5, .lambda_yaw_per_s = 0.2});
  EXPECT_LT((setpoint.v_H - Vector3d(0, 0.5, 0)).norm(), 1e-12);
  EXPECT_NEAR(setpoint.yaw_rate, -0.2 * std::numbers::pi / 2, 1e-12);
}

TEST(ServoSetpoint, SouthEastOfTheGoalFacingSouthItFliesBackAndRight) {
  const VelocitySetpoint setpoint = ServoSetpoint(HeadingPose({-0.4, 0.6, 0}, 180), {.lambda_per_s = 1});
  EXPECT_LT((setpoint.v_H - Vector3d(-0.4, 0.6, 0)).norm(), 1e-12);
}

TEST(ServoSetpoint, BelowTheGoalItClimbs) {
  const VelocitySetpoint setpoint =
      ServoSetpoint(HeadingPose({0, 0, 0.5}, 30), {.lambda_vertical_per_s = 0.7});
  EXPECT_LT((setpoint.v_H - Vector3d(0, 0, -0.35)).norm(), 1e-12);
}

TEST(ServoSetpoint, TurnsTheShorterWay) {
  EXPECT_GT(ServoSetpoint(HeadingPose({0, 0, 0}, 190), {}).yaw_rate, 0);
  EXPECT_LT(ServoSetpoint(HeadingPose({0, 0, 0}, 170), {}).yaw_rate, 0);
}

TEST(ServoSetpoint, LimitsKeepTheDirection) {
  const ServoGains gains{.lambda_per_s = 0.9,
                         .lambda_vertical_per_s = 0.9,
                         .lambda_yaw_per_s = 0.8,
                         .speed_limit_m_s = 1.5,
                         .climb_limit_m_s = 0.8,
                         .yaw_rate_limit_deg_s = 40};
  const Pose far = HeadingPose({30, -40, 20}, 120), near = HeadingPose({0.3, -0.4, 0.2}, 12);
  const VelocitySetpoint limited = ServoSetpoint(far, gains);
  EXPECT_NEAR(limited.v_H.head<2>().norm(), 1.5, 1e-12);
  // towards the goal as seen in N
  EXPECT_LT((far.R * Vector3d(limited.v_H.x(), limited.v_H.y(), 0) - 1.5 * Vector3d(-0.6, 0.8, 0)).norm(),
            1e-12);
  EXPECT_NEAR(limited.v_H.z(), -0.8, 1e-12);
  EXPECT_NEAR(limited.yaw_rate, -Radians(40), 1e-12);
  const VelocitySetpoint free = ServoSetpoint(near, gains);
  EXPECT_LT((near.R * free.v_H + 0.9 * near.p).norm(), 1e-12);
  EXPECT_NEAR(free.yaw_rate, -0.8 * Radians(12), 1e-12);
}

TEST(ServoSetpoint, FliesHomeAtConstantHeightAndYawGains) {
  const ServoGains gains{.lambda_per_s = 0.9,
                         .lambda_vertical_per_s = 0.9,
                         .lambda_yaw_per_s = 0.8,
                         .speed_limit_m_s = 10,
                         .climb_limit_m_s = 5,
                         .yaw_rate_limit_deg_s = 180};
  Pose X_DH = HeadingPose({2, -1, -1.5}, -140);
  const double dt = 1e-3;
  for (int step = 0; step < 2000; ++step) {
    const VelocitySetpoint setpoint = ServoSetpoint(X_DH, gains);
    X_DH = Moved(X_DH, {setpoint.v_H, {0, 0, setpoint.yaw_rate}}, dt);
  }
  EXPECT_LT((X_DH.p - std::exp(-0.9 * 2) * Vector3d(2, -1, -1.5)).norm(), 5e-3);
  EXPECT_NEAR(YawOf(X_DH.R), std::exp(-0.8 * 2) * Radians(-140), 5e-3);
}

}  // namespace
}  // namespace kestrel::control
