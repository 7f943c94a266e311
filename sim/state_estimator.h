// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "geometry/pose.h"
#include "sim/sensors.h"

namespace kestrel {

// The autopilot's own navigation: an error-state Kalman filter of position, velocity, attitude and the biases
// of gyroscopes and accelerometers, driven by the IMU and corrected by GPS, barometer and compass. J. Solà,
// "Quaternion kinematics for the error-state Kalman filter", 2017, with the attitude error in B. Its errors
// are those of such a filter on such sensors; no truth goes in after the start.
class StateEstimator {
 public:
  // At switch-on: where it thinks it stands, and the gyro bias that it averaged before take-off.
  StateEstimator(const SensorParameters& sensors, const Pose& X_NB, const Eigen::Vector3d& v_N,
                 const Eigen::Vector3d& gyro_bias);

  void Step(double dt_s, const SensorReadings& readings);
  // Takes an attitude for its own; sigma: rad, about any axis.
  void SetAttitude(const Eigen::Quaterniond& R_NB, double sigma);

  const Pose& X_NB() const { return X_NB_; }
  const Eigen::Vector3d& v_N() const { return v_N_; }
  const Eigen::Vector3d& w_B() const { return w_B_; }  // without the bias

 private:
  using Vector15 =
      Eigen::Matrix<double, 15, 1>;  // p_N, v_N, attitude (rotation vector in B), gyro and accelerometer bias
  using Matrix15 = Eigen::Matrix<double, 15, 15>;

  void Predict(double dt_s, const ImuSample& imu);
  // One scalar measurement: row of its Jacobian, innovation, variance.
  void Correct(const Vector15& h, double innovation, double variance);

  SensorParameters sensors_;
  Pose X_NB_;
  Eigen::Vector3d v_N_, w_B_ = Eigen::Vector3d::Zero(), gyro_bias_,
                        accelerometer_bias_ = Eigen::Vector3d::Zero();
  Matrix15 P_ = Matrix15::Zero();
  Vector15 error_ = Vector15::Zero();  // found by this step's corrections, not yet moved into the state
};

}  // namespace kestrel
