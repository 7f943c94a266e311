// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/moving_target.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kState_s = 0.01, kFrame_s = 0.05;

Eigen::Quaterniond LooksAhead() {
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return Eigen::Quaterniond(R_BC);
}
const Pose kMount{LooksAhead(), {0.1, 0, 0.05}};

// An aircraft that turns, tilts, climbs and flies an S, by formula.
VehicleState Aircraft(double t_s) {
  const auto attitude = [](double t) {
    return Eigen::Quaterniond(
        RotationFromTaitBryan({0.4 * t - 1, 0.15 * std::sin(1.3 * t), 0.2 * std::cos(0.9 * t)}));
  };
  VehicleState state;
  state.t_s = t_s;
  state.p_NB = {2 * std::sin(0.5 * t_s), t_s, -4 - 0.2 * t_s};
  state.v_N = {std::cos(0.5 * t_s), 1, -0.2};
  state.R_NB = attitude(t_s);
  constexpr double h = 1e-4;
  const Eigen::AngleAxisd turn(attitude(t_s - h).conjugate() * attitude(t_s + h));
  state.w_B = turn.angle() / (2 * h) * turn.axis();
  return state;
}

constexpr double kEnd_s = 6;
const Vector3d kTarget_v(-0.7, 1.1, 0.3);
Vector3d TargetAt(double t_s) { return Vector3d(6, 3, -5) + t_s * kTarget_v; }

Vector3d Seen(double t_s) {
  const VehicleState state = Aircraft(t_s);
  return (Pose{state.R_NB, state.p_NB} * kMount).Inverse() * TargetAt(t_s);
}

const Eigen::Matrix3d kCovariance = 1e-4 * Eigen::Matrix3d::Identity();

// What the autopilot gets wrong: a step of its position from a time on, and an error of its velocity.
struct Errors {
  Vector3d jump = Vector3d::Zero(), velocity = Vector3d::Zero();
};
constexpr double kJump_s = 5.72;

VehicleState Believed(double t_s, const Errors& errors) {
  VehicleState state = Aircraft(t_s);
  if (t_s >= kJump_s) state.p_NB += errors.jump;
  state.v_N += errors.velocity;
  return state;
}

// States every 10 ms and exact measurements every 50 ms, each 40 ms old when it comes.
MovingTarget Watched(const Errors& errors = {}, const MovingTargetOptions& options = {},
                     const Eigen::Matrix3d& covariance = kCovariance) {
  MovingTarget target(kMount, options);
  for (int i = 0; i <= std::lround(kEnd_s / kState_s); ++i) {
    const double t_s = i * kState_s;
    target.AddState(Believed(t_s, errors));
    if (i == 0 || i % std::lround(kFrame_s / kState_s) != 0) continue;
    EXPECT_TRUE(target.Correct(t_s - 0.04, Seen(t_s - 0.04), covariance));
  }
  return target;
}

TEST(MovingTarget, AnEvenMotionIsFoundWhileTheAircraftTurnsTiltsAndFlies) {
  const auto estimate = Watched().At(kEnd_s);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->age_s, 0.04, 1e-9);
  EXPECT_LT((estimate->p_N - TargetAt(kEnd_s)).norm(), 0.002);
  EXPECT_LT((estimate->v_N - kTarget_v).norm(), 0.01);
}

TEST(MovingTarget, TheCameraWillSeeItWhereItWillBe) {
  MovingTarget target = Watched();
  for (double t_s = kEnd_s + kState_s; t_s < kEnd_s + 0.3; t_s += kState_s) target.AddState(Aircraft(t_s));
  const auto p_CT = target.InCamera(kEnd_s + 0.2, 0.5);
  ASSERT_TRUE(p_CT);
  EXPECT_LT((*p_CT - Seen(kEnd_s + 0.2)).norm(), 0.005);
  EXPECT_FALSE(target.InCamera(kEnd_s + 0.2, 0.1));  // measured too long ago
  EXPECT_FALSE(target.InCamera(kEnd_s + 1, 2));      // nothing known of the aircraft then
}

TEST(MovingTarget, ItIsWhereItWillBeHadItGoneOn) {
  const auto now = Watched().At(kEnd_s), later = Watched().At(kEnd_s + 0.5);
  EXPECT_NEAR(later->age_s, 0.54, 1e-9);
  EXPECT_LT((later->p_N - now->p_N - 0.5 * now->v_N).norm(), 1e-12);
}

TEST(MovingTarget, AJumpOfTheAutopilotsPositionMovesNothingInTheRelativePlace) {
  const Errors errors{.jump = {0.6, -0.8, 0}};
  const auto with = Watched(errors).At(kEnd_s), without = Watched().At(kEnd_s);
  EXPECT_LT((with->p_N - Believed(kEnd_s, errors).p_NB - (without->p_N - Aircraft(kEnd_s).p_NB)).norm(),
            1e-12);
  EXPECT_LT((with->v_N - without->v_N).norm(), 1e-12);
  EXPECT_NEAR((with->p_N - without->p_N).norm(), 1, 1e-12);  // as seen from where it now says it is
}

TEST(MovingTarget, AnErrorOfTheAutopilotsVelocityIsTakenForTheTargetsAndLeavesTheRelativePlace) {
  const Errors errors{.velocity = {0.5, 0.3, -0.2}};
  const auto estimate = Watched(errors).At(kEnd_s);
  EXPECT_LT((estimate->v_N - kTarget_v - errors.velocity).norm(), 0.01);
  EXPECT_LT((estimate->p_N - TargetAt(kEnd_s)).norm(), 0.002);
}

// The steady state of a double integrator under white acceleration, by its Riccati equation: the variance of
// the velocity is sqrt(2) Q^(3/4) r^(1/4).
TEST(MovingTarget, TheVelocitysDeviationIsThatOfTheFilterInItsSteadyState) {
  const double Q = 0.3 * 0.3, r = 0.01 * kFrame_s;
  const auto estimate =
      Watched({}, {.acceleration_m_s2 = 0.3, .tilt_sigma_deg = 0}, 0.01 * Eigen::Matrix3d::Identity())
          .At(kEnd_s);
  const double expected = std::sqrt(std::sqrt(2) * std::pow(Q, 0.75) * std::pow(r, 0.25));
  EXPECT_NEAR(estimate->v_sigma, expected, 0.1 * expected);
}

TEST(MovingTarget, WhatIsOlderOrNewerThanAllThatIsRememberedOfTheAircraftIsRefused) {
  MovingTarget target(kMount, {});
  EXPECT_FALSE(target.Correct(0, {0, 0, 5}, kCovariance));
  for (int i = 0; i <= 500; ++i) target.AddState(Aircraft(i * kState_s));
  EXPECT_FALSE(target.Correct(2.5, Seen(2.5), kCovariance));
  EXPECT_FALSE(target.Correct(5.5, Seen(5.5), kCovariance));
  EXPECT_FALSE(target.At(5));
  EXPECT_TRUE(target.Correct(3.5, Seen(3.5), kCovariance));
  EXPECT_NEAR(target.At(5)->age_s, 1.5, 1e-12);
}

TEST(MovingTarget, WhatComesAfterANewerMeasurementIsRefused) {
  MovingTarget target = Watched();
  const auto before = target.At(kEnd_s);
  EXPECT_FALSE(target.Correct(kEnd_s - 0.5, Seen(kEnd_s - 0.5), kCovariance));
  const auto after = target.At(kEnd_s);
  EXPECT_EQ(after->p_N, before->p_N);
  EXPECT_EQ(after->age_s, before->age_s);
}

TEST(MovingTarget, WhatIsSeenFarFromWhereItShouldBeIsBelievedOnceItLasts) {
  MovingTarget target = Watched();
  const auto far = [](double t_s) { return Vector3d(Seen(t_s) + Vector3d(0, 0, 20)); };
  for (double t_s = kEnd_s; t_s < kEnd_s + 0.29; t_s += kFrame_s) {
    target.AddState(Aircraft(t_s));
    EXPECT_FALSE(target.Correct(t_s, far(t_s), kCovariance)) << t_s;
    EXPECT_LT((target.At(t_s)->p_N - TargetAt(t_s)).norm(), 0.01) << t_s;
  }
  const double lasting_s = kEnd_s + 0.31;
  target.AddState(Aircraft(lasting_s));
  EXPECT_TRUE(target.Correct(lasting_s, far(lasting_s), kCovariance));
  EXPECT_NEAR((target.At(lasting_s)->p_N - TargetAt(lasting_s)).norm(), 20, 0.01);
  EXPECT_EQ(target.At(lasting_s)->v_N, Vector3d::Zero());
}

TEST(MovingTarget, ItCountsWhatAgreesAndBeginsAnewWithWhatItBelievesInstead) {
  MovingTarget target = Watched();
  EXPECT_EQ(target.At(kEnd_s)->measurements, 120);
  target.Forget();
  target.Correct(kEnd_s, Seen(kEnd_s), kCovariance);
  EXPECT_EQ(target.At(kEnd_s)->measurements, 1);
}

TEST(MovingTarget, AMistakeInBetweenIsForgottenByTheNextGoodMeasurement) {
  MovingTarget target = Watched();
  for (int i = 0; i < 20; ++i) {
    const double t_s = kEnd_s + i * kFrame_s;
    target.AddState(Aircraft(t_s));
    const bool odd = i % 4 != 3;
    EXPECT_EQ(target.Correct(t_s, Seen(t_s) + Vector3d(0, 0, odd ? -4 : 0), kCovariance), !odd) << i;
  }
}

TEST(MovingTarget, ForgottenItIsUnknownAndBeginsAnewAtRest) {
  MovingTarget target = Watched();
  target.Forget();
  EXPECT_FALSE(target.At(kEnd_s));
  ASSERT_TRUE(target.Correct(kEnd_s, Seen(kEnd_s), kCovariance));
  EXPECT_LT((target.At(kEnd_s)->p_N - TargetAt(kEnd_s)).norm(), 1e-9);
  EXPECT_EQ(target.At(kEnd_s)->v_N, Vector3d::Zero());
}

TEST(LevelAhead, IsRightDownAndAheadOfTheHeading) {
  // Heading east: ahead is east, to the right is south.
  EXPECT_LT((LevelAhead({7, 26, -6}, {10, 20, -5}, Radians(90)) - Vector3d(3, -1, 6)).norm(), 1e-12);
  EXPECT_LT((LevelAhead({7, 26, -6}, {10, 20, -5}, 0) - Vector3d(6, -1, -3)).norm(), 1e-12);
}

TEST(LevelAhead, IsWhatACameraAheadSeesOfALevelAircraftWhateverTheTiltOfTheRealOne) {
  for (const double yaw : {-2.5, 0.0, 0.7}) {
    const Pose X_NC{HeadingRotation(yaw) * LooksAhead(), {1, 2, -3}};
    EXPECT_LT((LevelAhead({4, -5, -6}, X_NC.p, yaw) - X_NC.Inverse() * Vector3d(4, -5, -6)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace kestrel::control
