// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "control/autopilot.h"
#include "control/estimate/velocity_lag.h"

namespace kestrel::control {

// What an autopilot that follows velocities late has yet to fly of those that it was given: a law that servoes
// the place where the aircraft will be then, in place of that where it is, has the late answer outside of its
// loop (O. J. M. Smith, "Closer control of loops with dead time", 1957, of a plant that integrates).
//
// With an autopilot that is late by L a position p follows p'(t) = v(t - L), so p(t + L) = p(t) + the integral
// of v over the last L. By v = -lambda p(t + L) the error falls as exp(-lambda t), as without the lateness. A
// lag of first order is taken for a dead time as late: both answer slow motions alike.
//
// L is measured as the flight goes (VelocityLagEstimator). An autopilot that answers within kPrompt_s counts
// as not late at all: the gains are for such ones.
class LateFollowing {
 public:
  static constexpr double kPromptLevel_s = 0.35, kPromptClimb_s = 0.45;

  // What answers as fast as this is prompt, and how its lateness is measured.
  struct Kind {
    double prompt_level_s = kPromptLevel_s, prompt_climb_s = kPromptClimb_s;
    LagSearch search = {};
  };
  // Of rates of turn, rad/s, about the vertical as the third axis. The rate gyros tell them soon and well.
  static Kind OfTurns();

  LateFollowing() : LateFollowing(Kind{}) {}
  explicit LateFollowing(const Kind& kind) : kind_(kind), estimator_(kind.search) {}

  // Of each frame, in the order of time: the velocity that is flown, on which what is given next is decided.
  void Hear(double t_s, const Eigen::Vector3d& flown_N);
  void Hear(const VehicleState& state) { Hear(state.t_s, state.v_N); }
  // What the autopilot is given on the state that was heard last, m/s, and what is flown by it where that is
  // something else, as the autopilot errs in its own velocity. The last word on a state counts; a state on
  // which nothing is given begins anew, but for the lateness.
  void Give(const Eigen::Vector3d& asked_N, const Eigen::Vector3d& flown_N);

  // The way that will yet be flown, m.
  Eigen::Vector3d ToCome_N() const;
  // By how much it is late, as it was measured last; 0: it is prompt, or that is not known yet.
  double level_s() const { return level_s_; }
  double climb_s() const { return climb_s_; }

 private:
  struct Given {
    double t_s;
    Eigen::Vector3d flown_N;
  };
  double Way(int axis, double late_s) const;

  struct Heard {
    double t_s;
    Eigen::Vector3d flown_N;
  };
  Kind kind_;
  VelocityLagEstimator estimator_;
  std::optional<Heard> heard_;                                        // last
  std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> given_;  // on that: asked, flown
  std::deque<Given> past_;
  double measured_s_ = 0;
  double level_s_ = 0, climb_s_ = 0;
};

}  // namespace kestrel::control
