// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/deck/deck_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

TEST(OscillatorTest, IsTheSolutionOfItsEquationAndStaysAsWideAsItIs) {
  const Oscillator swing{0.9, 0.2, 1.5};
  Eigen::Matrix2d A;
  A << 0, 1, -0.81, -2 * 0.2 * 0.9;
  for (const double dt : {0.01, 0.5, 3.0}) {
    EXPECT_LT((swing.Transition(dt) - (dt * A).exp()).norm(), 1e-12) << dt;
    const Eigen::Matrix2d F = swing.Transition(dt);
    EXPECT_LT((F * swing.Stationary() * F.transpose() + swing.Noise(dt) - swing.Stationary()).norm(), 1e-12);
    EXPECT_GE(swing.Noise(dt).eigenvalues().real().minCoeff(), -1e-12);
  }
}

// A deck seen from above by an aircraft that hovers, drifts and rocks, 50 ms late, with noise.
struct Sight {
  Pose X_BC{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ())), {0, 0, 0.05}};
  DeckEstimator estimator;
  std::mt19937 random{7};
  std::normal_distribution<double> noise;
  double own_error_m_s = 0;  // of the autopilot's velocity, northwards

  explicit Sight(const DeckEstimatorOptions& options) : estimator(X_BC, options) {}

  Pose Aircraft(double t) const {
    return {Eigen::Quaterniond(RotationFromTaitBryan({0.2, 0.05 * std::sin(t), 0.06 * std::cos(1.3 * t)})),
            Vector3d(0.3 * t, 0, -5)};
  }
  // One frame: the state at t + 0.05 and the pad as exposed at t.
  void Frame(double t, const Pose& X_NT, bool seen = true) {
    VehicleState state;
    state.t_s = t + 0.05;
    const Pose X_NB = Aircraft(state.t_s);
    state.R_NB = X_NB.R;
    const double dt = 1e-4;
    state.w_B = LogRotation(X_NB.R.conjugate() * Aircraft(state.t_s + dt).R) / dt;
    state.v_N = Vector3d(0.3 + own_error_m_s, 0, 0);
    estimator.AddState(state);
    if (!seen) return;
    Pose X_CT = (Aircraft(t) * X_BC).Inverse() * X_NT;
    X_CT.p += 0.01 * Vector3d(noise(random), noise(random), noise(random));
    X_CT.R = ExpRotation(0.01 * Vector3d(noise(random), noise(random), noise(random))) * X_CT.R;
    estimator.Correct(t, X_CT, 1e-4 * Eigen::Matrix<double, 6, 6>::Identity());
  }
};

TEST(DeckEstimatorTest, KnowsADrivenDecksVelocityAndItsPlaceThroughLatencyAndALoss) {
  DeckEstimatorOptions options;
  options.acceleration_m_s2 = 0.5;
  Sight sight(options);
  sight.own_error_m_s = 0.2;
  const auto deck = [](double t) { return Pose{HeadingRotation(0.4), Vector3d(4 * t, 1 - 2 * t, -1)}; };
  int n = 0;
  for (double t = 0; t < 4; t += 1.0 / 30, ++n) sight.Frame(t, deck(t), n < 90);  // the last second unseen
  const double now = 4 + 0.05 - 1.0 / 30;
  const auto at = sight.estimator.At(now);
  const auto in_O = sight.estimator.Aircraft(now);
  ASSERT_TRUE(at && in_O);
  EXPECT_GT(at->age_s, 0.9);
  // By the aircraft's own velocity, whose error it shares.
  EXPECT_LT((at->v_N - Vector3d(4.2, -2, 0)).norm(), 0.15);
  const Vector3d from = in_O->p_NB - at->p_OT, truly = sight.Aircraft(now).p - deck(now).p;
  EXPECT_LT((from - truly).norm(), 0.25);
  EXPECT_NEAR(at->yaw, 0.4, 0.02);
  EXPECT_LT(std::acos(at->normal_N.z()), Radians(0.5));
}

TEST(DeckEstimatorTest, PredictsHeaveAndRollASecondAhead) {
  DeckEstimatorOptions options;
  options.heave_m = 0.5, options.tilt_deg = 3, options.tilt_sigma_deg = 0.6;
  Sight sight(options);
  const auto deck = [](double t) {
    return Pose{Eigen::Quaterniond(RotationFromTaitBryan({0, 0, Radians(4) * std::sin(0.7 * t)})),
                Vector3d(0.3 * t, 0, -4 + 0.6 * std::sin(0.8 * t + 1))};
  };
  double worst_m_s = 0, worst_deg = 0, off_m_s = 0, off_deg = 0;
  int checked = 0;
  for (double t = 0; t < 40; t += 1.0 / 30) {
    sight.Frame(t, deck(t));
    if (t < 10) continue;
    ++checked;
    const auto ahead = sight.estimator.At(t + 1);
    const double v = 0.48 * std::cos(0.8 * (t + 1) + 1);
    worst_m_s = std::max(worst_m_s, std::abs(ahead->v_N.z() - v));
    worst_deg = std::max(
        worst_deg, Degrees(std::acos(std::min(1.0, ahead->normal_N.dot(deck(t + 1).R * Vector3d::UnitZ())))));
    // Against its standing still.
    off_m_s = std::max(off_m_s, std::abs(0.48 * std::cos(0.8 * t + 1) - v));
    off_deg = std::max(off_deg, 4 * std::abs(std::sin(0.7 * t) - std::sin(0.7 * (t + 1))));
  }
  EXPECT_GT(checked, 500);
  EXPECT_LT(worst_m_s, 0.6 * off_m_s);
  EXPECT_LT(worst_deg, 0.75 * off_deg);
}

TEST(DeckEstimatorTest, DoesNotBelieveOneFixThatIsFarOffButARunOfThem) {
  Sight sight(DeckEstimatorOptions{});
  const Pose deck{Eigen::Quaterniond::Identity(), {0, 0, -1}};
  double t = 0;
  for (; t < 1; t += 0.05) sight.Frame(t, deck);
  const Vector3d before = sight.estimator.At(t)->p_OT;
  const Pose elsewhere{Eigen::Quaterniond::Identity(), {3, 0, -1}};
  sight.Frame(t += 0.05, elsewhere);
  EXPECT_LT((sight.estimator.At(t)->p_OT - before).norm(), 0.1);
  EXPECT_GT(sight.estimator.At(t)->age_s, 0.04);
  for (int i = 0; i < 6; ++i) sight.Frame(t += 0.05, elsewhere);
  EXPECT_GT((sight.estimator.At(t)->p_OT - before).norm(), 2.5);
}

}  // namespace
}  // namespace kestrel::control
