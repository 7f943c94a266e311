// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "control/autopilot.h"
#include "sim/autopilot/state_estimator.h"
#include "sim/sensor/sensor_monitor.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

// What an autopilot knows of itself: the estimate of its own sensors, with the faults of its attitude, and
// while it is sent attitudes from outside a second one that takes these. A fault that ends leaves the own
// attitude levelled anew, by the accelerometers and the compass. It does without a sensor that is stuck, but
// for the inertial ones.
class Navigation {
 public:
  // timeout_s: after which an aid is stale. The rest as in StateEstimator.
  Navigation(const SensorParameters& sensors, double timeout_s, const Pose& X_NB,
             const Eigen::Vector3d& gyro_bias);

  void ChangeFaults(std::vector<AttitudeFault> faults) { sensors_.attitude_faults = std::move(faults); }
  // t_s: of the autopilot's clock, at the end of the step.
  void Step(double dt_s, double t_s, const SensorReadings& readings);
  void Aid(const control::AttitudeAid& aid);

  const StateEstimator& InUse() const { return aided_ ? *aided_ : own_; }
  bool aided() const { return aided_.has_value(); }
  std::optional<Eigen::Quaterniond> InertialAttitude() const;  // none: it is silent
  NavigationHealth Health() const;

 private:
  void LevelAnew();
  void StepEstimators(double dt_s, double t_s, const SensorReadings& readings);

  SensorParameters sensors_;
  double timeout_s_;
  Eigen::Vector3d gyro_bias_;  // at switch-on
  SensorMonitor watch_;
  StateEstimator own_;
  std::optional<StateEstimator> aided_;
  double aid_age_s_ = 0;
  bool failed_ = false, silent_ = false;  // the own attitude
  Eigen::Vector3d force_B_{0, 0, -1};     // the specific force, smoothed, m/s^2
  Eigen::Vector3d field_B_{1, 0, 0};      // the magnetic field, as last heard, T
};

}  // namespace kestrel::sim
