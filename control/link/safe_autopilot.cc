// SPDX-License-Identifier: Apache-2.0
#include "control/link/safe_autopilot.h"

#include <chrono>
#include <utility>

#include "base/stopwatch.h"

namespace kestrel::control {

SafeAutopilot::SafeAutopilot(AutopilotLink& link, std::function<std::optional<double>()> image_age_s,
                             const Options& options)
    : link_(link),
      image_age_s_(std::move(image_age_s)),
      options_(options),
      safety_{Hazard::kNoSetpoint, MonotonicNow_s()},
      thread_([this] { Watch(); }) {}

SafeAutopilot::~SafeAutopilot() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
  link_.Silence();
}

VehicleState SafeAutopilot::State() const {
  const VehicleState state = link_.State();
  const std::lock_guard lock(mutex_);
  if (Sane(state)) last_sane_ = state;
  return last_sane_;
}

void SafeAutopilot::Send(const Setpoint& setpoint) {
  const std::lock_guard lock(mutex_);
  wanted_ = setpoint;
  wanted_at_s_ = MonotonicNow_s();
  Act();
}

void SafeAutopilot::Aid(const AttitudeAid& aid) {
  const std::lock_guard lock(mutex_);
  if (!options_.dry_run && !release_) link_.Aid(aid);
}

std::optional<Released> SafeAutopilot::LetGo(const ReleaseLimits& limits) {
  std::unique_lock lock(mutex_);
  if (options_.dry_run) return std::nullopt;
  if (!release_) {
    release_ = limits;
    release_state_ = {MonotonicNow_s(), {}};
    Act();
  }
  wake_.wait(lock, [this] { return released_.has_value(); });
  return released_;
}

void SafeAutopilot::TargetLostFor(double seconds) {
  const std::lock_guard lock(mutex_);
  target_lost_s_ = seconds;
}

std::vector<SafetyChange> SafeAutopilot::TakeChanges() {
  const std::lock_guard lock(mutex_);
  return std::exchange(changes_, {});
}

std::optional<Setpoint> SafeAutopilot::sent() const {
  const std::lock_guard lock(mutex_);
  return sent_;
}

void SafeAutopilot::Act() {
  if (released_) return;
  const LinkHealth health = link_.Health();
  Situation now;
  now.t_s = MonotonicNow_s();
  now.pilot_allows = health.pilot_allows.value_or(options_.pilot_untold);
  now.state = link_.State();
  now.state_age_s = health.state_age_s;
  now.image_age_s = image_age_s_();
  now.target_lost_s = target_lost_s_;
  if (now.t_s - wanted_at_s_ <= options_.limits.image_s) now.wanted = wanted_;
  now.start_N = options_.start_N;
  if (release_) return Hold(now);
  const SafeCommand command = MakeSafe(now, safety_, options_.limits);
  safety_ = command.state;
  sent_ = command.setpoint;
  if (!options_.dry_run) {
    if (command.setpoint)
      link_.Send(*command.setpoint);
    else
      link_.Silence();
  }
  if (!last_ || last_->hazard != safety_.hazard || last_->reaction != command.reaction ||
      last_->limited != command.limited) {
    last_ = SafetyChange{now.t_s, safety_.hazard, command.reaction, command.limited};
    changes_.push_back(*last_);
  }
}

void SafeAutopilot::Hold(const Situation& now) {
  const Release how = kestrel::control::LetGo(now, release_state_, options_.limits, *release_);
  if (how == Release::kHolding) {
    sent_ = VelocitySetpoint{};
    link_.Send(*sent_);
    return;
  }
  sent_.reset();
  link_.Silence();
  released_ = Released{how, now.t_s - release_state_.since_s};
  wake_.notify_all();
}

void SafeAutopilot::Watch() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    Act();
    wake_.wait_for(lock, std::chrono::duration<double>(kPeriod_s));
  }
}

}  // namespace kestrel::control
