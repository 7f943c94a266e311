// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/constant_velocity_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/video/tracking.hpp>
#include <random>

namespace kestrel::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6 = ConstantVelocityFilter::Matrix6;
using Vector6 = ConstantVelocityFilter::Vector6;

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  Vector3d Vector(double sigma) { return {sigma * Normal(), sigma * Normal(), sigma * Normal()}; }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
};

Matrix6 TransitionOver(double dt) {
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = dt * Matrix3d::Identity();
  return F;
}

// The covariance that a white acceleration adds: the integral of F(s) G q^2 G' F(s)' over the step, by
// midpoints.
Matrix6 IntegratedNoise(double dt, double acceleration) {
  constexpr int kSteps = 2000;
  Matrix6 sum = Matrix6::Zero();
  for (int i = 0; i < kSteps; ++i) {
    const Matrix6 F = TransitionOver(dt * (i + 0.5) / kSteps);
    sum += acceleration * acceleration * F.rightCols<3>() * F.rightCols<3>().transpose() * dt / kSteps;
  }
  return sum;
}

Vector6 StateOf(const ConstantVelocityFilter& filter) {
  Vector6 x;
  x << filter.position(), filter.velocity();
  return x;
}

TEST(ConstantVelocityFilter, ProcessNoiseIsTheIntegralOfAWhiteAcceleration) {
  for (const double dt : {0.01, 0.3, 2.0}) {
    ConstantVelocityFilter filter(Vector3d::Zero(), 0, Vector3d::Zero(), 0, 0.7);
    filter.Predict(dt);
    const Matrix6 expected = IntegratedNoise(dt, 0.7);
    EXPECT_LT((filter.covariance() - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(ConstantVelocityFilter, TwoShortPredictionsAreOneLong) {
  ConstantVelocityFilter once({1, 2, 3}, 0.2, {-1, 0.5, 2}, 0.3, 0.6), twice = once;
  once.Predict(0.5);
  twice.Predict(0.2);
  twice.Predict(0.3);
  EXPECT_LT((once.position() - Vector3d(0.5, 2.25, 4)).norm(), 1e-12);
  EXPECT_LT((StateOf(once) - StateOf(twice)).norm(), 1e-12);
  EXPECT_LT((once.covariance() - twice.covariance()).norm(), 1e-12);
}

TEST(ConstantVelocityFilter, DoesAsOpenCvsKalmanFilter) {
  Random random(1);
  ConstantVelocityFilter filter({1, -2, 3}, 0.5, {0.1, 0.2, -0.3}, 0.4, 0.8);
  cv::KalmanFilter oracle(6, 3, 0, CV_64F);
  oracle.statePost = (cv::Mat_<double>(6, 1) << 1, -2, 3, 0.1, 0.2, -0.3);
  cv::setIdentity(oracle.measurementMatrix);
  oracle.errorCovPost = cv::Mat::diag((cv::Mat_<double>(6, 1) << 0.25, 0.25, 0.25, 0.16, 0.16, 0.16));
  for (int i = 0; i < 100; ++i) {
    const double dt = 0.01 + 0.002 * (i % 30);
    filter.Predict(dt);
    cv::eigen2cv(TransitionOver(dt), oracle.transitionMatrix);
    cv::eigen2cv(IntegratedNoise(dt, 0.8), oracle.processNoiseCov);
    oracle.predict();
    if (i % 3 != 0) {
      const Vector3d z = random.Vector(1);
      const Matrix3d factor = 0.1 * Matrix3d::Identity() + 0.05 * Matrix3d::Ones() * random.Normal();
      const Matrix3d R = factor * factor.transpose();
      filter.Correct(z, R);
      cv::eigen2cv(R, oracle.measurementNoiseCov);
      cv::Mat measurement;
      cv::eigen2cv(z, measurement);
      oracle.correct(measurement);
    }
    const bool corrected = i % 3 != 0;
    Vector6 x;
    Matrix6 P;
    cv::cv2eigen(corrected ? oracle.statePost : oracle.statePre, x);
    cv::cv2eigen(corrected ? oracle.errorCovPost : oracle.errorCovPre, P);
    ASSERT_LT((StateOf(filter) - x).norm(), 1e-6) << i;
    ASSERT_LT((filter.covariance() - P).norm(), 1e-6) << i;
  }
}

// A body under a finely stepped white acceleration: normalised errors squared have as mean the number of
// dimensions.
TEST(ConstantVelocityFilter, CovarianceIsThatOfItsErrors) {
  constexpr int kRuns = 400, kFrames = 30, kSubsteps = 40;
  const double dt = 0.1, acceleration = 0.9, position_sigma = 0.3, velocity_sigma = 0.5;
  Matrix3d L;
  L << 0.05, 0, 0, 0.02, 0.04, 0, -0.03, 0.01, 0.06;
  const Matrix3d R = L * L.transpose();
  Random random(2);
  double nees = 0, nis = 0;
  for (int run = 0; run < kRuns; ++run) {
    Vector3d p = random.Vector(10), v = random.Vector(2);
    ConstantVelocityFilter filter(p + random.Vector(position_sigma), position_sigma,
                                  v + random.Vector(velocity_sigma), velocity_sigma, acceleration);
    for (int frame = 0; frame < kFrames; ++frame) {
      const double h = dt / kSubsteps;
      for (int k = 0; k < kSubsteps; ++k) {
        const Vector3d jump = random.Vector(acceleration * std::sqrt(h));
        p += h * (v + jump / 2);
        v += jump;
      }
      filter.Predict(dt);
      const Vector3d z = p + L * random.Vector(1), innovation = z - filter.position();
      if (frame == kFrames - 1) {
        const Matrix3d S = filter.covariance().topLeftCorner<3, 3>() + R;
        nis += innovation.dot(S.inverse() * innovation) / kRuns;
      }
      filter.Correct(z, R);
    }
    Vector6 truth;
    truth << p, v;
    const Vector6 error = truth - StateOf(filter);
    nees += error.dot(filter.covariance().inverse() * error) / kRuns;
  }
  // four deviations of the mean of as many chi-square numbers
  EXPECT_NEAR(nees, 6, 4 * std::sqrt(2 * 6.0 / kRuns));
  EXPECT_NEAR(nis, 3, 4 * std::sqrt(2 * 3.0 / kRuns));
}

TEST(ConstantVelocityFilter, CovarianceStaysSymmetricAndPositive) {
  ConstantVelocityFilter filter(Vector3d::Zero(), 10, Vector3d::Zero(), 10, 5);
  for (int i = 0; i < 5000; ++i) {
    filter.Predict(i % 50 == 0 ? 2 : 1e-3);
    filter.Correct({1, 2, 3}, Vector3d(1e-10, 1e-6, 1).asDiagonal());
  }
  const Matrix6& P = filter.covariance();
  EXPECT_LT((P - P.transpose()).norm(), 1e-12 * P.norm());
  EXPECT_GT(P.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
  EXPECT_LT((filter.position() - Vector3d(1, 2, 3)).norm(), 1e-4);
}

}  // namespace
}  // namespace kestrel::control
