// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "geometry/pose.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// The autopilot's own navigation: an error-state Kalman filter of position, velocity, attitude and the biases
// of gyroscopes and accelerometers, driven by the IMU and corrected by GPS, barometer and compass. J. Solà,
// "Quaternion kinematics for the error-state Kalman filter", 2017, with the attitude error in B. Its errors
// are those of such a filter on such sensors; no truth goes in after the start.
//
// A measurement whose innovation is more than five of its deviations is refused. One that is refused for five
// seconds on end is believed: what the filter thought it knew of that is forgotten (PX4's EKF2 resets its
// states so). But not a height while the other sensor of heights is in use.
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

  // Refused for a second at least, and still.
  bool refuses_gps() const {
    return Lasts(gps_level_, kNamed_s) || Lasts(gps_height_, kNamed_s) || Lasts(gps_velocity_, kNamed_s);
  }
  bool refuses_barometer() const { return Lasts(barometer_, kNamed_s); }
  bool refuses_compass() const { return Lasts(compass_, kNamed_s); }

 private:
  using Vector15 =
      Eigen::Matrix<double, 15, 1>;  // p_N, v_N, attitude (rotation vector in B), gyro and accelerometer bias
  using Matrix15 = Eigen::Matrix<double, 15, 15>;

  static constexpr double kNamed_s = 1;

  struct Gate {
    double used_s = -1e9;           // when a measurement was used last
    std::optional<double> since_s;  // all have been refused
  };
  enum class Verdict { kUse, kRefuse, kBelieve };

  void Predict(double dt_s, const ImuSample& imu);
  bool Lasts(const Gate& gate, double time_s) const { return gate.since_s && t_s_ - *gate.since_s >= time_s; }
  // ratio: the largest square of an innovation over its variance. trusted: another sensor says the same.
  Verdict Judge(Gate& gate, double ratio, bool trusted);
  double Ratio(const Vector15& h, double innovation, double variance) const;
  void CorrectByGps(const GpsSample& gps);
  // What is known along h is forgotten, as far as it contradicts an innovation.
  void Forget(const Vector15& h, double innovation) { P_ += innovation * innovation * h * h.transpose(); }
  void StartAnewIfBroken();
  // One scalar measurement: row of its Jacobian, innovation, variance.
  void Correct(const Vector15& h, double innovation, double variance);

  SensorParameters sensors_;
  Pose X_NB_;
  Eigen::Vector3d v_N_, w_B_ = Eigen::Vector3d::Zero(), gyro_bias_,
                        accelerometer_bias_ = Eigen::Vector3d::Zero();
  Matrix15 P_ = Matrix15::Zero();
  double t_s_ = 0;  // since switch-on
  Gate gps_level_, gps_height_, gps_velocity_, barometer_, compass_;
  Vector15 error_ = Vector15::Zero();  // found by this step's corrections, not yet moved into the state
};

}  // namespace kestrel::sim
