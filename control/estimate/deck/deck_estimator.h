// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/estimate/deck/kalman.h"
#include "control/estimate/deck/oscillator.h"
#include "control/estimate/state_history.h"
#include "geometry/pose.h"

namespace kestrel::control {

struct DeckEstimatorOptions {
  double acceleration_m_s2 = 1, acceleration_s = 2;
  double heave_m = 0.02, heave_period_s = 8;
  double tilt_deg = 0.3, tilt_period_s = 8;
  double damping = 0.15;
  double position_sigma_m = 0.01, tilt_sigma_deg = 1.5;
};

inline void Fields(FieldVisitor& v, DeckEstimatorOptions& o) {
  v({"acceleration_m_s2", "standard deviation of the deck's level acceleration"}, o.acceleration_m_s2, 0.01,
    20.0);
  v({"acceleration_s", "time for which that lasts"}, o.acceleration_s, 0.1, 60.0);
  v({"heave_m", "standard deviation of the deck's heave"}, o.heave_m, 0.001, 10.0);
  v({"heave_period_s", "its period"}, o.heave_period_s, 1.0, 40.0);
  v({"tilt_deg", "standard deviation of the deck's roll, and of its pitch"}, o.tilt_deg, 0.01, 30.0);
  v({"tilt_period_s", "their period"}, o.tilt_period_s, 1.0, 40.0);
  v({"damping", "damping ratio with which heave, roll and pitch swing, each as an oscillator"}, o.damping,
    0.01, 0.9);
  v({"position_sigma_m", "standard deviation that is added to each position fix, beside its own covariance"},
    o.position_sigma_m, 1e-4, 1.0);
  v({"tilt_sigma_deg", "the same of the deck's tilt in a fix"}, o.tilt_sigma_deg, 0.01, 20.0);
}

// Where a moving deck is, from camera poses of the pad on it and the autopilot's states, and where it will be.
//
// Its place is kept in O, a frame with the axes of N that drifts as the integral of the autopilot's velocity does:
// that has no jumps, and the error of the velocity is common to the aircraft and the deck, so that a setpoint made
// from the deck's velocity is free of it.
//
// Level, each axis: position, velocity, and an acceleration that fades (R. A. Singer, IEEE Trans. AES 6(4), 1970).
// Height: a mean with a drift, and heave as an Oscillator. The normal's two level parts: an Oscillator each. Heading:
// an angle and its rate. All are Kalman filters.
class DeckEstimator {
 public:
  struct Deck {
    Eigen::Vector3d p_OT = Eigen::Vector3d::Zero();  // m
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();   // m/s
    Eigen::Vector3d a_N = Eigen::Vector3d::Zero();   // m/s^2
    Eigen::Vector3d normal_N{0, 0, 1};               // unit, into the deck: down where it is level
    double yaw = 0, yaw_rate = 0;                    // rad, rad/s
    double sigma_m = 0;                              // of its level place, each axis
    double age_s = 0;                                // since the exposure of the last accepted fix
  };

  DeckEstimator(const Pose& X_BC, const DeckEstimatorOptions& options);

  // Every state of the autopilot, before the frames that are exposed before it.
  void AddState(const VehicleState& state);

  // A camera pose of the pad at an exposure; returns the aircraft's pose X_TB by this frame alone. None: no state
  // for that time, or a fix so far from the estimate that it is not believed; a run of such is believed in the end.
  std::optional<Pose> Correct(double t_s, const Pose& X_CT, const Eigen::Matrix<double, 6, 6>& covariance);

  // At a time, also one to come. None: the deck has never been seen, or has been forgotten.
  std::optional<Deck> At(double t_s) const;
  // The pad's pose in the camera at a time about now. None: nothing known.
  std::optional<Pose> ExpectedPose(double t_s) const;
  // The aircraft, with p_NB in O. None: no state about that time.
  std::optional<VehicleState> Aircraft(double t_s) const { return history_.At(t_s); }

  void Forget() { seen_ = false; }

 private:
  struct Filters {
    Kalman<3> level[2];  // position, velocity, acceleration
    Kalman<4> height;    // mean, its rate, heave, its rate: down
    Kalman<2> tilt[2];   // part of the normal, its rate
    Kalman<2> yaw;
    void Predict(double dt_s, const DeckEstimatorOptions& options);
  };
  void Begin(const Pose& X_OT);

  Pose X_BC_;
  DeckEstimatorOptions options_;
  StateHistory history_;
  std::optional<VehicleState> last_;  // with p_NB in O
  Filters filters_;
  double t_s_ = 0, fixed_s_ = 0;  // of them, and of the last fix that was accepted
  bool seen_ = false;
  int refused_ = 0;
};

}  // namespace kestrel::control
