// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/estimate/constant_velocity_filter.h"
#include "control/estimate/state_history.h"
#include "control/estimate/tilt_alignment.h"
#include "geometry/pose.h"

namespace kestrel::control {

struct TargetEstimatorOptions {
  double acceleration_m_s2 = 0.6;
  double position_sigma_m = 0.004;
  double velocity_time_s = 0.9;
  bool tilt_alignment = true;
};

inline void Fields(FieldVisitor& v, TargetEstimatorOptions& o) {
  v({"acceleration_m_s2",
     "acceleration noise of the aircraft's constant-velocity model over the pad, per root hertz"},
    o.acceleration_m_s2, 0.01, 20.0);
  v({"position_sigma_m", "standard deviation that is added to each position fix, beside its own covariance"},
    o.position_sigma_m, 1e-4, 1.0);
  v({"velocity_time_s", "time constant with which the error of the autopilot's velocity is estimated"},
    o.velocity_time_s, 0.2, 60.0);
  v({"tilt_alignment", "correct the pad's pose by the autopilot's tilt, and that tilt by the pose"},
    o.tilt_alignment);
}

// Where the aircraft is over a level target, from camera poses of the target and the autopilot's states: eq.
// (4.6) to (4.8) with what a moving, tilting, late camera needs. Deviation: the filter runs in the target's
// frame T, where velocity is nearly constant; in the camera frame of the thesis every tilt of the aircraft
// moves the target.
class TargetEstimator {
 public:
  struct Estimate {
    Eigen::Vector3d p_TB = Eigen::Vector3d::Zero();              // m
    Eigen::Vector3d v_T = Eigen::Vector3d::Zero();               // m/s
    double yaw_TB = 0;                                           // rad
    Eigen::Vector3d velocity_error_T = Eigen::Vector3d::Zero();  // the autopilot's velocity less the true one
    double age_s = 0;  // since the exposure of the last accepted fix
  };

  TargetEstimator(const Pose& X_BC, const TargetEstimatorOptions& options);

  // Every state of the autopilot, before the frames that are exposed before it.
  void AddState(const VehicleState& state);

  // The target's pose in the camera at a time, from what is known so far. None: nothing known, or too long
  // ago.
  std::optional<Pose> ExpectedPose(double t_s) const;

  // A camera pose of the target at an exposure; returns the aircraft's pose X_TB by this frame alone, with
  // the tilt mended. None: no state of the autopilot for that time, or the fix is so far from the estimate
  // that it is not believed; a run of such fixes is believed in the end.
  std::optional<Pose> Correct(double t_s, const Pose& X_CT, const Eigen::Matrix<double, 6, 6>& covariance);

  // The estimate carried to a time by the filter's velocity and what the autopilot has felt since. None: the
  // target has never been seen.
  std::optional<Estimate> At(double t_s) const;

  void Forget();  // the target's place, not the autopilot's errors

 private:
  Pose X_BC_;
  TargetEstimatorOptions options_;
  StateHistory history_;
  TiltAlignment tilt_;
  std::optional<ConstantVelocityFilter> filter_;  // of p_TB
  double filter_t_s_ = 0;
  double yaw_NT_ = 0;  // the target's yaw on the autopilot's compass
  Eigen::Vector3d velocity_error_T_ = Eigen::Vector3d::Zero();
  int refused_ = 0;
};

}  // namespace kestrel::control
