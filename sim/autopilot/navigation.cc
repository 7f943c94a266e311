// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/navigation.h"

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kForceTime_s = 1;
const double kFailedSigma = Radians(1.5);

// The attitude in which "down" and magnetic north are where they are felt.
Eigen::Quaterniond LevelledBy(const Eigen::Vector3d& down_B, const Eigen::Vector3d& field_B) {
  Eigen::Matrix3d R_NB;
  R_NB.row(2) = down_B.normalized();
  R_NB.row(1) = down_B.cross(field_B).normalized();  // east
  R_NB.row(0) = R_NB.row(1).cross(R_NB.row(2));
  return Eigen::Quaterniond(R_NB);
}

}  // namespace

Navigation::Navigation(const SensorParameters& sensors, double timeout_s, const Pose& X_NB,
                       const Eigen::Vector3d& gyro_bias)
    : sensors_(sensors),
      timeout_s_(timeout_s),
      gyro_bias_(gyro_bias),
      watch_(sensors),
      own_(sensors, X_NB, Eigen::Vector3d::Zero(), gyro_bias) {}

void Navigation::Step(double dt_s, double t_s, const SensorReadings& readings) {
  watch_.Step(dt_s, readings);
  const NavigationHealth& health = watch_.health();
  const bool stuck = health.compass == SensorHealth::kStuck || health.barometer == SensorHealth::kStuck ||
                     health.gps == SensorHealth::kStuck;
  if (!stuck) return StepEstimators(dt_s, t_s, readings);
  SensorReadings sound = readings;
  if (health.compass == SensorHealth::kStuck) sound.field_B.reset();
  if (health.barometer == SensorHealth::kStuck) sound.height_m.reset();
  if (health.gps == SensorHealth::kStuck) sound.gps.reset();
  StepEstimators(dt_s, t_s, sound);
}

void Navigation::StepEstimators(double dt_s, double t_s, const SensorReadings& readings) {
  force_B_ += (1 - std::exp(-dt_s / kForceTime_s)) * (readings.imu.specific_force_B - force_B_);
  if (readings.field_B) field_B_ = *readings.field_B;

  const AttitudeFault* fault = FaultAt(sensors_.attitude_faults, t_s);
  if (failed_ && !fault) LevelAnew();
  failed_ = fault != nullptr;
  silent_ = fault && fault->type == "silent";
  const Eigen::Quaterniond before = own_.X_NB().R;
  own_.Step(dt_s, readings);
  if (fault) {  // its corrections no longer reach it
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
    if (fault->type == "drift") rate = own_.w_B() + fault->drift_deg_s.unaryExpr(&Radians);
    own_.SetAttitude((before * ExpRotation(dt_s * rate)).normalized(), kFailedSigma);
  }

  if (!aided_) return;
  aid_age_s_ += dt_s;
  aided_->Step(dt_s, readings);
  if (aid_age_s_ > timeout_s_) aided_.reset();
}

void Navigation::Aid(const control::AttitudeAid& aid) {
  if (!aided_) aided_ = own_;
  aided_->SetAttitude(aid.R_NB, aid.sigma);
  aid_age_s_ = 0;
}

void Navigation::LevelAnew() {
  Pose X_NB = InUse().X_NB();
  X_NB.R = LevelledBy(-force_B_, field_B_);
  own_ = StateEstimator(sensors_, X_NB, InUse().v_N(), gyro_bias_);
}

NavigationHealth Navigation::Health() const {
  NavigationHealth health = watch_.health();
  const auto add = [](bool refused, SensorHealth& of) {
    if (refused && of == SensorHealth::kOk) of = SensorHealth::kRefused;
  };
  add(InUse().refuses_compass(), health.compass);
  add(InUse().refuses_barometer(), health.barometer);
  add(InUse().refuses_gps(), health.gps);
  return health;
}

std::optional<Eigen::Quaterniond> Navigation::InertialAttitude() const {
  if (silent_) return std::nullopt;
  return own_.X_NB().R;
}

}  // namespace kestrel::sim
