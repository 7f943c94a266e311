// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "control/link/autopilot_link.h"
#include "control/safety/release.h"
#include "control/safety/safety.h"

namespace kestrel::control {

// What the safety layer did, from then on.
struct SafetyChange {
  double t_s = 0;  // of the monotonic clock
  Hazard hazard = Hazard::kNone;
  Reaction reaction = Reaction::kSilence;
  bool limited = false;
};

// How the aircraft was let go, and how long that took.
struct Released {
  Release how = Release::kHolding;
  double after_s = 0;
};

// An autopilot as flight code may have it: between the two stands MakeSafe, at once when a setpoint comes,
// and on a thread of its own every kPeriod_s whether one comes or not. A setpoint that is older than the
// limits allow an image to be counts as none. Flight code never sees a state that is not sane: it gets the
// last one that was, and the reaction to a lost state runs.
class SafeAutopilot final : public Autopilot {
 public:
  static constexpr double kPeriod_s = 0.02;

  struct Options {
    SafetyLimits limits;
    Eigen::Vector3d start_N = Eigen::Vector3d::Zero();  // the middle of the area, on the ground
    bool dry_run = false;                               // all is reckoned and nothing sent
    bool pilot_untold = false;  // an autopilot that does not tell of his switch is flown all the same
  };
  // image_age_s: of the newest image, asked from the thread. The link must outlive this.
  SafeAutopilot(AutopilotLink& link, std::function<std::optional<double>()> image_age_s,
                const Options& options);
  ~SafeAutopilot() override;  // silences the link

  VehicleState State() const override;
  void Send(const Setpoint& setpoint) override;
  void Aid(const AttitudeAid& aid) override;

  // Lets the aircraft go (control/safety/release.h), and comes back when the wire is silent, after
  // ReleaseLimits::max_s at most. From its call on nothing else is sent, whatever is asked for. Of a dry
  // run, which has nothing in force: none.
  std::optional<Released> LetGo(const ReleaseLimits& limits = {});

  void TargetLostFor(double seconds);  // as flight code sees it; 0: in sight, or it has none
  std::vector<SafetyChange> TakeChanges();
  std::optional<Setpoint> sent() const;  // last, after the safety layer; none: the wire is silent

 private:
  void Act();  // with the lock held
  void Hold(const Situation& now);
  void Watch();  // the thread

  AutopilotLink& link_;
  std::function<std::optional<double>()> image_age_s_;
  Options options_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  mutable VehicleState last_sane_;
  std::optional<Setpoint> wanted_, sent_;
  double wanted_at_s_ = 0, target_lost_s_ = 0;
  SafetyState safety_;
  std::optional<SafetyChange> last_;
  std::vector<SafetyChange> changes_;
  std::optional<ReleaseLimits> release_;  // the aircraft is being let go, or was
  ReleaseState release_state_;
  std::optional<Released> released_;
  std::thread thread_;
};

}  // namespace kestrel::control
