// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/target_estimator.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  Vector3d Vector(double sigma) { return {sigma * Normal(), sigma * Normal(), sigma * Normal()}; }

 private:
  double Normal() { return normal_(rng_); }
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
};

// A camera under the aircraft that looks down, the top of its image ahead.
Pose CameraMount() {
  Eigen::Matrix3d R_BC;
  R_BC << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return {Eigen::Quaterniond(R_BC), {0.1, 0.02, 0.05}};
}

constexpr double kYawNT = 0.7;           // of the target on the compass
const Vector3d kOriginOfN_T(12, -7, 3);  // the autopilot was switched on elsewhere
constexpr double kStateStep_s = 0.01, kFrameStep_s = 1 / 30.0, kLatency_s = 0.06;

// What the autopilot does not know.
struct Flaws {
  Vector3d velocity_bias_N = Vector3d::Zero();
  Vector3d tilt_B = Vector3d::Zero();  // rotation vector, rad
};

// A swaying aircraft four metres above the target.
struct Flight {
  Flaws flaws;

  static Vector3d PlaceT(double t) {
    return {0.5 * std::sin(0.7 * t), 0.4 * std::cos(0.5 * t), -4 + 0.3 * std::sin(0.4 * t)};
  }
  static Vector3d VelocityT(double t) {
    return {0.35 * std::cos(0.7 * t), -0.2 * std::sin(0.5 * t), 0.12 * std::cos(0.4 * t)};
  }
  static Pose TruthTB(double t) {
    const TaitBryan attitude{0.3 * std::sin(0.3 * t) - 1.1, 0.06 * std::sin(1.1 * t),
                             0.07 * std::cos(0.9 * t)};
    return {Eigen::Quaterniond(RotationFromTaitBryan(attitude)), PlaceT(t)};
  }
  static Pose TruthCT(double t) { return (TruthTB(t) * CameraMount()).Inverse(); }

  VehicleState StateAt(double t) const {
    const Pose X_TB = TruthTB(t);
    const Eigen::Quaterniond R_NT = HeadingRotation(kYawNT);
    const double h = 1e-4;
    VehicleState state;
    state.t_s = t;
    state.p_NB = R_NT * (X_TB.p - kOriginOfN_T) + t * flaws.velocity_bias_N;
    state.v_N = R_NT * VelocityT(t) + flaws.velocity_bias_N;
    state.w_B = LogRotation(TruthTB(t - h).R.conjugate() * TruthTB(t + h).R) / (2 * h);
    state.R_NB = R_NT * X_TB.R * ExpRotation(flaws.tilt_B);
    return state;
  }
};

Matrix6 FixCovariance() {
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << 1e-5, 1e-5, 4e-5, 3e-5, 3e-5, 1e-5;
  return covariance;
}

Pose Noisy(const Pose& X_CT, Random& random) {
  const Eigen::Matrix<double, 6, 1> sigma = FixCovariance().diagonal().cwiseSqrt();
  return {ExpRotation(random.Vector(1).cwiseProduct(sigma.tail<3>())) * X_CT.R,
          X_CT.p + random.Vector(1).cwiseProduct(sigma.head<3>())};
}

// Flies from one time to another with fixes that arrive late; returns the time up to which states were heard.
double Fly(const Flight& flight, double from_s, double to_s, TargetEstimator& estimator, Random& random) {
  double heard_s = from_s;
  estimator.AddState(flight.StateAt(heard_s));
  for (int frame = 0;; ++frame) {
    const double exposure_s = from_s + frame * kFrameStep_s;
    if (exposure_s + kLatency_s > to_s) return heard_s;
    while (heard_s + kStateStep_s <= exposure_s + kLatency_s) {
      heard_s += kStateStep_s;
      estimator.AddState(flight.StateAt(heard_s));
    }
    estimator.Correct(exposure_s, Noisy(Flight::TruthCT(exposure_s), random), FixCovariance());
  }
}

TEST(TargetEstimator, KnowsNothingBeforeItHasSeenTheTarget) {
  TargetEstimator estimator(CameraMount(), {});
  EXPECT_FALSE(estimator.At(1));
  EXPECT_FALSE(estimator.ExpectedPose(1));
  EXPECT_FALSE(estimator.Correct(1, Flight::TruthCT(1), FixCovariance()));  // no state of that time
  estimator.AddState(Flight{}.StateAt(1));
  EXPECT_FALSE(estimator.At(1));
  EXPECT_TRUE(estimator.Correct(1, Flight::TruthCT(1), FixCovariance()));
  EXPECT_TRUE(estimator.At(1));
  EXPECT_FALSE(estimator.Correct(9, Flight::TruthCT(9), FixCovariance()));
}

TEST(TargetEstimator, OneExactFixGivesThePlaceAndTheYaw) {
  TargetEstimator estimator(CameraMount(), {});
  const Flight flight;
  for (const double t : {0.98, 0.99, 1.0, 1.01}) estimator.AddState(flight.StateAt(t));
  const auto X_TB = estimator.Correct(1, Flight::TruthCT(1), FixCovariance());
  ASSERT_TRUE(X_TB);
  const Pose truth = Flight::TruthTB(1);
  EXPECT_LT((X_TB->p - truth.p).norm(), 1e-6);
  EXPECT_LT(LogRotation(X_TB->R * truth.R.conjugate()).norm(), 1e-6);
  const auto estimate = estimator.At(1);
  ASSERT_TRUE(estimate);
  EXPECT_LT((estimate->p_TB - truth.p).norm(), 1e-6);
  EXPECT_LT((estimate->v_T - Flight::VelocityT(1)).norm(), 1e-6);
  EXPECT_NEAR(estimate->yaw_TB, YawOf(truth.R), 1e-6);
  EXPECT_EQ(estimate->age_s, 0);
}

TEST(TargetEstimator, ConvergesOnLateFixesOfAFlawedAutopilot) {
  const Flight flight{{.velocity_bias_N = {0.25, -0.15, 0.1}, .tilt_B = {Radians(0.8), Radians(-0.6), 0}}};
  const Vector3d bias_T = HeadingRotation(-kYawNT) * flight.flaws.velocity_bias_N;
  TargetEstimator estimator(CameraMount(), {});
  Random random(1);
  double now_s = 0;
  double sum = 0;
  int count = 0;
  for (int second = 0; second < 40; ++second) {
    now_s = Fly(flight, now_s, now_s + 1, estimator, random);
    if (second < 20) continue;
    const auto estimate = estimator.At(now_s);
    ASSERT_TRUE(estimate);
    EXPECT_LT((estimate->p_TB - Flight::PlaceT(now_s)).norm(), 0.03) << second;
    EXPECT_LT((estimate->v_T - Flight::VelocityT(now_s)).norm(), 0.1) << second;
    EXPECT_LT(std::abs(WrapAngle(estimate->yaw_TB - YawOf(Flight::TruthTB(now_s).R))), Radians(0.6))
        << second;
    EXPECT_LT((estimate->velocity_error_T - bias_T).norm(), 0.1) << second;
    EXPECT_GE(estimate->age_s, kLatency_s - kStateStep_s);
    EXPECT_LE(estimate->age_s, kLatency_s + kFrameStep_s);
    sum += (estimate->velocity_error_T - bias_T).norm();
    ++count;
  }
  EXPECT_LT(sum / count, 0.05);
}

TEST(TargetEstimator, ExpectedPoseIsThatOfTheCamera) {
  const Flight flight{{.tilt_B = {Radians(1), 0, 0}}};
  TargetEstimator estimator(CameraMount(), {});
  Random random(2);
  const double now_s = Fly(flight, 0, 20, estimator, random);
  const auto expected = estimator.ExpectedPose(now_s);
  ASSERT_TRUE(expected);
  const Pose truth = Flight::TruthCT(now_s);
  EXPECT_LT((expected->p - truth.p).norm(), 0.04);
  const Vector3d turn = LogRotation(expected->R * truth.R.conjugate());
  EXPECT_LT(turn.head<2>().norm(), Radians(0.15));  // the autopilot's own tilt is a degree off
  EXPECT_LT(std::abs(turn.z()), Radians(0.6));
}

TEST(TargetEstimator, TiltAlignmentMendsTheFix) {
  const Flight flight{{.tilt_B = {0, Radians(1), 0}}};
  double with = 0, without = 0;
  for (const bool aligned : {true, false}) {
    TargetEstimator estimator(CameraMount(), {.tilt_alignment = aligned});
    Random random(3);
    double now_s = Fly(flight, 0, 20, estimator, random);
    for (int i = 0; i < 100; ++i) {
      now_s += kFrameStep_s;
      estimator.AddState(flight.StateAt(now_s));
      // far more tilt noise than before: mostly hidden, say
      Matrix6 covariance = FixCovariance();
      covariance.diagonal().tail<3>().setConstant(std::pow(Radians(2), 2));
      Pose seen = Flight::TruthCT(now_s);
      seen.R = ExpRotation(random.Vector(Radians(2))) * seen.R;
      const auto X_TB = estimator.Correct(now_s, seen, covariance);
      ASSERT_TRUE(X_TB);
      (aligned ? with : without) += (X_TB->p - Flight::PlaceT(now_s)).head<2>().squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(with), 0.3 * std::sqrt(without));
}

TEST(TargetEstimator, RefusesAWildFixAndBelievesARunOfThem) {
  const Flight flight;
  TargetEstimator estimator(CameraMount(), {});
  Random random(4);
  double now_s = Fly(flight, 0, 5, estimator, random);
  const auto wild = [&] {
    now_s += kFrameStep_s;
    estimator.AddState(flight.StateAt(now_s));
    Pose X_CT = Flight::TruthCT(now_s);
    X_CT.p += Vector3d(3, 0, 0);
    return estimator.Correct(now_s, X_CT, FixCovariance());
  };
  const auto good = [&] {
    now_s += kFrameStep_s;
    estimator.AddState(flight.StateAt(now_s));
    return estimator.Correct(now_s, Flight::TruthCT(now_s), FixCovariance());
  };
  for (int i = 0; i < 20; ++i) {  // single ones never make a run
    EXPECT_FALSE(wild());
    EXPECT_LT((estimator.At(now_s)->p_TB - Flight::PlaceT(now_s)).norm(), 0.05);
    EXPECT_GT(estimator.At(now_s)->age_s, 0.9 * kFrameStep_s);
    EXPECT_TRUE(good());
  }
  int refused = 0;
  while (!wild()) ASSERT_LT(++refused, 20);
  EXPECT_GE(refused, 3);
  EXPECT_NEAR((estimator.At(now_s)->p_TB - Flight::PlaceT(now_s)).norm(), 3, 0.1);
}

// A turn by w of a camera that knows the direction to the target moves the target by w x p_CT and leaves the
// camera.
TEST(TargetEstimator, WeighsAFixByWhatItsCovarianceSaysOfThePlace) {
  for (const double sign : {1.0, -1.0}) {
    TargetEstimator estimator(CameraMount(), {.tilt_alignment = false});
    const Flight flight;
    for (const double t : {0.98, 0.99, 1.0, 1.01}) estimator.AddState(flight.StateAt(t));
    Matrix6 rough = Matrix6::Zero();
    rough.diagonal().setConstant(0.1 * 0.1);
    rough.diagonal().tail<3>().setConstant(1e-6);
    const Pose truth = Flight::TruthCT(1);
    ASSERT_TRUE(estimator.Correct(1, truth, rough));
    Matrix6 L = Matrix6::Zero();
    L.topLeftCorner<3, 3>() = 0.005 * Eigen::Matrix3d::Identity();
    L.bottomRightCorner<3, 3>() = Radians(4) * Eigen::Matrix3d::Identity();
    L.topRightCorner<3, 3>() = -sign * Skew(truth.p) * L.bottomRightCorner<3, 3>();
    const Vector3d off_T(0.2, 0, 0);  // what the second fix says else
    const Pose second = (Pose{Flight::TruthTB(1).R, Flight::PlaceT(1) + off_T} * CameraMount()).Inverse();
    ASSERT_TRUE(estimator.Correct(1, second, L * L.transpose()));
    const double moved = (estimator.At(1)->p_TB - Flight::PlaceT(1)).x() / 0.2;
    if (sign > 0) {
      EXPECT_GT(moved, 0.9);
    } else {
      EXPECT_LT(moved, 0.2);
    }
  }
}

TEST(TargetEstimator, CarriesTheEstimateOverALossOfTheTarget) {
  const Flight flight{{.velocity_bias_N = {0.4, 0.3, 0}}};
  constexpr int kFlights = 20;
  double sum = 0;
  for (int i = 0; i < kFlights; ++i) {
    TargetEstimator estimator(CameraMount(), {});
    Random random(50 + i);
    const double lost_s = Fly(flight, 0, 20 + 0.5 * i, estimator, random);
    const double age_s = estimator.At(lost_s)->age_s;
    for (double t = lost_s; t < lost_s + 1.5; t += kStateStep_s) estimator.AddState(flight.StateAt(t));
    const auto estimate = estimator.At(lost_s + 1.4);
    ASSERT_TRUE(estimate);
    EXPECT_NEAR(estimate->age_s, age_s + 1.4, 1e-9);
    EXPECT_TRUE(estimator.ExpectedPose(lost_s + 1.4));
    sum += (estimate->p_TB - Flight::PlaceT(lost_s + 1.4)).squaredNorm();
    for (double t = lost_s + 1.5; t < lost_s + 4; t += kStateStep_s) estimator.AddState(flight.StateAt(t));
    EXPECT_FALSE(estimator.ExpectedPose(lost_s + 3.9));  // too long ago to look there
  }
  EXPECT_LT(std::sqrt(sum / kFlights), 0.3);  // by the reported velocity it would be 0.7 m
}

TEST(TargetEstimator, DoesNotFollowAJumpOfTheAutopilotsPosition) {
  const Flight flight;
  TargetEstimator estimator(CameraMount(), {});
  Random random(6);
  const double now_s = Fly(flight, 0, 5, estimator, random);
  const auto before = estimator.At(now_s);
  VehicleState state = flight.StateAt(now_s);
  state.p_NB += Vector3d(5, 5, 5);  // a correction by satellites
  estimator.AddState(state);
  ASSERT_TRUE(before);
  EXPECT_LT((estimator.At(now_s)->p_TB - before->p_TB).norm(), 1e-12);
}

TEST(TargetEstimator, ForgetsThePlaceAndNotTheAutopilotsErrors) {
  const Flight flight{{.velocity_bias_N = {0.3, -0.2, 0.1}}};
  TargetEstimator estimator(CameraMount(), {});
  Random random(7);
  const double now_s = Fly(flight, 0, 20, estimator, random);
  const Vector3d learnt = estimator.At(now_s)->velocity_error_T;
  estimator.Forget();
  EXPECT_FALSE(estimator.At(now_s));
  EXPECT_FALSE(estimator.ExpectedPose(now_s));
  ASSERT_TRUE(estimator.Correct(now_s, Flight::TruthCT(now_s), FixCovariance()));
  EXPECT_EQ(estimator.At(now_s)->velocity_error_T, learnt);
  EXPECT_GT(learnt.norm(), 0.3);
}

}  // namespace
}  // namespace kestrel::control
