// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <limits>
#include <optional>

// How late an autopilot follows the velocities that it is given, and how late the loop that gives them
// allows. Late is meant as the mean of the impulse response: T of a lag of first order, tau of a delay, T +
// tau of one after the other.
namespace kestrel::control {

struct VelocityLag {
  double horizontal_s = std::numeric_limits<double>::infinity();
  double vertical_s = std::numeric_limits<double>::infinity();
};

// The most for v = lambda e, which servoes a position by its error e (control/law/pbvs.h).
//
// With an autopilot that is late by a delay tau the open loop is lambda exp(-s tau) / s. It has the gain 1 at
// w = lambda, whatever tau, where its phase is -pi/2 - lambda tau: the phase margin is pi/2 - lambda tau. Of
// a lag of first order that is as late, the phase at w is atan(w T) < w T and the gain below 1, so its margin
// is greater; the same holds for any chain of lags and delays. The delay is the worst of them, and for
// a margin m
//
//   tau <= (pi/2 - m) / lambda,   m = 30 degrees: tau <= pi / (3 lambda).
//
// That keeps a factor of 1.5 to the gain at which it no longer settles. Not reckoned: what the sight is late,
// which the estimators of these loops make up for. Endless for lambda = 0.
double MaxLag(double lambda_per_s);

// Which lags and delays are tried, and what tells of them.
struct LagSearch {
  double step_s = 0.1, max_delay_s = 1.6, max_lag_s = 2;
  double least_s = 5;  // of samples, beyond the longest delay
  // Root mean square about the mean, m/s: less tells nothing. Up and down an estimate wanders more, with the
  // barometer.
  double moved_level = 0.07, moved_climb = 0.15;
};

// The lateness by what was commanded and flown in the last kWindow_s: of all lags of first order after
// delays, those that explain it best, by least squares. The flown velocity may be off by a constant.
class VelocityLagEstimator {
 public:
  static constexpr double kWindow_s = 20;

  struct Late {
    double s = 0;
    double min_s = 0;  // whatever is less late explains it much worse
  };

  explicit VelocityLagEstimator(const LagSearch& search = {}) : search_(search) {}

  // In the order of time. t_s: of the flown velocity, on the clock of commanded_s. None commanded: not
  // a velocity, or nothing: what came before counts no more.
  void Add(double commanded_s, const std::optional<Eigen::Vector3d>& commanded_N, double t_s,
           const Eigen::Vector3d& flown_N);

  // None: too little was flown or moved, or no such answer explains what was flown, as in gusts or at a
  // limit.
  std::optional<Late> Horizontal() const { return Fit(0, 2); }
  std::optional<Late> Vertical() const { return Fit(2, 1); }

 private:
  struct Sample {
    double commanded_s;
    Eigen::Vector3d commanded_N;
    double t_s;
    Eigen::Vector3d flown_N;
  };
  std::optional<Late> Fit(int axis, int axes) const;

  LagSearch search_;
  std::deque<Sample> samples_;
};

}  // namespace kestrel::control
