// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/state_estimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

// The wander of GPS and barometer is not white: taking each sample for worse than it is keeps the filter from
// believing that many samples average it away.
constexpr double kGpsPositionSigma_m = 1.0;
constexpr double kBarometerSigma_m = 0.4;
constexpr double kCompassSigma_rad = 0.03;
// Least deviation taken for a GPS velocity: a measurement without any leaves the filter 0 / 0.
constexpr double kGpsVelocitySigma_m_s = 0.01;
constexpr double kGate = 5;           // deviations; of PX4's EKF2 for GPS and barometer
constexpr double kBelieved_s = 5;     // how long refused
constexpr double kTiltForgotten = 1;  // rad, at most

}  // namespace

StateEstimator::StateEstimator(const SensorParameters& sensors, const Pose& X_NB, const Eigen::Vector3d& v_N,
                               const Eigen::Vector3d& gyro_bias)
    : sensors_(sensors), X_NB_(X_NB), v_N_(v_N), gyro_bias_(gyro_bias) {
  P_.diagonal() << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(std::pow(Radians(1.5), 2)), Eigen::Vector3d::Constant(1e-6),
      Eigen::Vector3d::Constant(std::pow(sensors.accelerometer_turn_on_m_s2, 2));
}

void StateEstimator::Step(double dt_s, const SensorReadings& readings) {
  t_s_ += dt_s;
  Predict(dt_s, readings.imu);
  if (readings.gps) CorrectByGps(*readings.gps);
  const auto correct = [&](Gate& gate, const Vector15& h, double innovation, double variance, bool trusted) {
    const Verdict verdict = Judge(gate, Ratio(h, innovation, variance), trusted);
    if (verdict == Verdict::kBelieve) Forget(h, innovation);
    if (verdict != Verdict::kRefuse) Correct(h, innovation, variance);
  };
  if (readings.height_m) {
    correct(barometer_, -Vector15::Unit(2), *readings.height_m + X_NB_.p.z(),
            kBarometerSigma_m * kBarometerSigma_m, t_s_ - gps_height_.used_s < kBelieved_s);
  }
  if (readings.field_B) {
    const Eigen::Vector3d field_N = X_NB_.R * *readings.field_B;
    Vector15 h = Vector15::Zero();
    h.segment<3>(6) = X_NB_.R.conjugate() * Eigen::Vector3d::UnitZ();  // a turn of B about down
    correct(compass_, h, -std::atan2(field_N.y(), field_N.x()), kCompassSigma_rad * kCompassSigma_rad, false);
  }
  X_NB_.p += error_.segment<3>(0);
  v_N_ += error_.segment<3>(3);
  X_NB_.R = (X_NB_.R * ExpRotation(error_.segment<3>(6))).normalized();
  gyro_bias_ += error_.segment<3>(9);
  accelerometer_bias_ += error_.segment<3>(12);
  error_.setZero();
  StartAnewIfBroken();
}

void StateEstimator::CorrectByGps(const GpsSample& gps) {
  const double velocity_sigma = std::max(sensors_.gps_velocity_m_s.white, kGpsVelocitySigma_m_s);
  const double velocity_variance = velocity_sigma * velocity_sigma;
  Vector15 innovation = Vector15::Zero(), variance = Vector15::Zero();
  for (int i = 0; i < 3; ++i) {
    const double position_sigma = i < 2 ? kGpsPositionSigma_m : 3 * kGpsPositionSigma_m;
    innovation(i) = gps.p_N(i) - X_NB_.p(i);
    variance(i) = position_sigma * position_sigma;
    innovation(3 + i) = gps.v_N(i) - v_N_(i);
    variance(3 + i) = velocity_variance;
  }
  const auto ratio = [&](int i) { return Ratio(Vector15::Unit(i), innovation(i), variance(i)); };
  const double refused_s = gps_velocity_.since_s ? t_s_ - *gps_velocity_.since_s : 0;
  const Verdict level = Judge(gps_level_, std::max(ratio(0), ratio(1)), false);
  const Verdict height = Judge(gps_height_, ratio(2), t_s_ - barometer_.used_s < kBelieved_s);
  const Verdict velocity = Judge(gps_velocity_, std::max({ratio(3), ratio(4), ratio(5)}), false);
  if (velocity == Verdict::kBelieve) {
    // A velocity that went astray in that time did so by a tilt: let it be found.
    const double tilt =
        std::min(kTiltForgotten, innovation.segment<3>(3).norm() / (kGravity_m_s2 * refused_s));
    P_.diagonal().segment<3>(6).array() += tilt * tilt;
  }
  for (int i = 0; i < 3; ++i) {
    for (const auto& [verdict, at] : {std::pair(i < 2 ? level : height, i), std::pair(velocity, 3 + i)}) {
      if (verdict == Verdict::kBelieve) Forget(Vector15::Unit(at), innovation(at));
      if (verdict != Verdict::kRefuse) Correct(Vector15::Unit(at), innovation(at), variance(at));
    }
  }
}

double StateEstimator::Ratio(const Vector15& h, double innovation, double variance) const {
  return innovation * innovation / (h.dot(P_ * h) + variance);
}

StateEstimator::Verdict StateEstimator::Judge(Gate& gate, double ratio, bool trusted) {
  const bool passes = ratio <= kGate * kGate;  // what is not a number does not
  if (!passes && (trusted || !std::isfinite(ratio) || !Lasts(gate, kBelieved_s))) {
    if (!gate.since_s) gate.since_s = t_s_;
    return Verdict::kRefuse;
  }
  gate.since_s.reset();
  gate.used_s = t_s_;
  return passes ? Verdict::kUse : Verdict::kBelieve;
}

// Sensors that rave can take the covariances beyond what numbers hold.
void StateEstimator::StartAnewIfBroken() {
  if (P_.diagonal().minCoeff() >= 0 && P_.diagonal().sum() < 1e12) return;
  P_.setZero();
  P_.diagonal() << Eigen::Vector3d::Constant(1e4), Eigen::Vector3d::Constant(1e2),
      Eigen::Vector3d::Constant(1), Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(0.1);
  gyro_bias_.setZero();
  accelerometer_bias_.setZero();
}

void StateEstimator::SetAttitude(const Eigen::Quaterniond& R_NB, double sigma) {
  X_NB_.R = R_NB;
  P_.middleRows<3>(6).setZero();
  P_.middleCols<3>(6).setZero();
  P_.diagonal().segment<3>(6).setConstant(sigma * sigma);
}

void StateEstimator::Predict(double dt_s, const ImuSample& imu) {
  w_B_ = imu.w_B - gyro_bias_;
  const Eigen::Vector3d force_B = imu.specific_force_B - accelerometer_bias_;
  const Eigen::Matrix3d R = X_NB_.R.toRotationMatrix();
  const Eigen::Vector3d a_N = R * force_B + Eigen::Vector3d(0, 0, kGravity_m_s2);
  X_NB_.p += dt_s * v_N_ + dt_s * dt_s / 2 * a_N;
  v_N_ += dt_s * a_N;
  X_NB_.R = (X_NB_.R * ExpRotation(dt_s * w_B_)).normalized();

  // P becomes F P F^T. F is the identity but for five blocks of three rows and columns: a whole product would be nearly
  // all multiplications by 0.
  const Eigen::Matrix3d velocity_of_turn = -dt_s * R * Skew(force_B), velocity_of_bias = -dt_s * R,
                        turn_of_turn = Eigen::Matrix3d::Identity() - dt_s * Skew(w_B_);
  for (int side = 0; side < 2; ++side) {  // P F^T, and as P is symmetric, the same of its transpose
    P_.middleCols<3>(0) += dt_s * P_.middleCols<3>(3);
    for (int k = 0; k < 3; ++k) P_.middleCols<3>(3) += P_.col(6 + k) * velocity_of_turn.col(k).transpose();
    for (int k = 0; k < 3; ++k) P_.middleCols<3>(3) += P_.col(12 + k) * velocity_of_bias.col(k).transpose();
    P_.middleCols<3>(6) =
        (P_.middleCols<3>(6).lazyProduct(turn_of_turn.transpose()) - dt_s * P_.middleCols<3>(9)).eval();
    P_.transposeInPlace();
  }
  const auto add = [&](int at, double density) {
    P_.diagonal().segment<3>(at).array() += density * density * dt_s;
  };
  add(3, sensors_.accelerometer_noise_m_s2_rthz);
  add(6, sensors_.gyro_noise_rad_s_rthz);
  add(9, sensors_.gyro_walk_rad_s2_rthz);
  add(12, sensors_.accelerometer_walk_m_s3_rthz);
}

void StateEstimator::Correct(const Vector15& h, double innovation, double variance) {
  const Vector15 Ph = P_ * h;
  const double s = h.dot(Ph) + variance;
  const Vector15 k = Ph / s;
  error_ += k * (innovation - h.dot(error_));
  P_ -= k * Ph.transpose();
  P_ = ((P_ + P_.transpose()) / 2).eval();
}

}  // namespace kestrel::sim
