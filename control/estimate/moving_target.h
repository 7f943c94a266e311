// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/estimate/constant_velocity_filter.h"
#include "control/estimate/state_history.h"
#include "geometry/pose.h"

namespace kestrel::control {

struct MovingTargetOptions {
  double acceleration_m_s2 = 6;
  double tilt_sigma_deg = 0.3;
};

inline void Fields(FieldVisitor& v, MovingTargetOptions& o) {
  v({"acceleration_m_s2", "acceleration noise of the target's constant-velocity model, per root hertz"},
    o.acceleration_m_s2, 0.01, 50.0);
  v({"tilt_sigma_deg", "standard deviation of the autopilot's attitude from one image to the next"},
    o.tilt_sigma_deg, 0.0, 10.0);
}

// Where a target is that moves in any way, by what a camera measured at its exposures: eqs. (4.6) to (4.8) in
// a frame where neither the turns nor the tilts of the aircraft move it. Its axes are those of N; its places
// are the sum of the autopilot's velocities, which is smoother than the autopilot's position with its jumps
// from fix to fix, and drifts: what drifts is taken for the target's own motion, and as aircraft and target
// are both in it, nothing is lost.
class MovingTarget {
 public:
  struct Estimate {
    Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  // m, as seen from where the autopilot says it is
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
    double v_sigma = 0;                             // of any component of it, at most
    double age_s = 0;                               // since the exposure of the last measurement
    int measurements = 0;                           // that agree with each other
  };

  MovingTarget(const Pose& X_BC, const MovingTargetOptions& options);

  void AddState(
      const VehicleState& state);  // every state of the autopilot, before the frames exposed before it

  // A place in C at an exposure, m, with its covariance. False: no state of the autopilot for that time, or
  // it is older than the last, or it is far off where the target should be: that is believed once it lasts.
  bool Correct(double t_s, const Eigen::Vector3d& p_CT, const Eigen::Matrix3d& covariance);

  // Where it should be in C at an exposure. None: the last measurement is older than this, or no state of the
  // autopilot for that time.
  std::optional<Eigen::Vector3d> InCamera(double t_s, double most_age_s) const;

  std::optional<Estimate> At(double t_s) const;  // none: never measured, or forgotten
  void Forget() { filter_.reset(), odd_since_s_.reset(); }

 private:
  Pose X_BC_;
  MovingTargetOptions options_;
  StateHistory history_;  // with the summed place
  std::optional<VehicleState> last_;
  Eigen::Vector3d summed_N_ = Eigen::Vector3d::Zero();
  std::optional<ConstantVelocityFilter> filter_;
  double filter_t_s_ = 0;
  int measurements_ = 0;
  std::optional<double> odd_since_s_;
};

// A place as a level camera that looks straight ahead from there would have it (right, down, ahead), of an
// aircraft at p_N with that yaw: thesis 5.4, without its assumption that the tilt is small.
Eigen::Vector3d LevelAhead(const Eigen::Vector3d& p_NT, const Eigen::Vector3d& p_N, double yaw);

}  // namespace kestrel::control
