// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/control_monitor.h"

#include <fmt/format.h>

namespace kestrel::flight {
namespace {

// A mission that asks for nothing, for instance once it has landed, has the aircraft all the same.
bool ByTheMission(const control::SafetyChange& safety) {
  return safety.reaction == control::Reaction::kFly || safety.hazard == control::Hazard::kNoSetpoint;
}

std::string By(const char* what, const control::SafetyChange& safety) {
  if (safety.hazard == control::Hazard::kPilot) return fmt::format("{} by the pilot", what);
  if (safety.hazard == control::Hazard::kStateLost) return fmt::format("{} without link", what);
  return fmt::format("{} by the safety layer: {}", what, control::NameOf(safety.hazard));
}

}  // namespace

void ControlMonitor::Note(double t_s, const control::SafetyChange& safety,
                          const control::VehicleState& state) {
  last_ = safety;
  flew_ = flew_ || safety.reaction == control::Reaction::kFly;
  if (flew_ && !silent_ && safety.reaction == control::Reaction::kSilence) silent_ = safety;
  if (safety.reaction == control::Reaction::kSink) sunk_ = safety, sunk_->t_s = t_s;
  if (!state.landed) {
    airborne_ = true;
    landing_.reset();
  } else if (airborne_ && !landing_) {
    const bool just_sunk = sunk_ && t_s - sunk_->t_s <= kTouchDown_s;
    landing_ = ByTheMission(safety) && just_sunk ? *sunk_ : safety;
  }
}

ControlMonitor::Verdict ControlMonitor::Judge(const std::string& outcome, const std::string& why,
                                              bool accomplished) const {
  if (landing_ && !ByTheMission(*landing_)) return {By("landed", *landing_), false};
  const bool own = landing_ || !last_ || ByTheMission(*last_);
  if (!outcome.empty() && !accomplished) return {outcome, false};
  if (outcome.empty() && why != kTimeIsUp) return {why, false};
  if (!own) return {By("ended", *last_), false};
  if (accomplished && !airborne_) return {"never left the ground", false};
  if (outcome.empty() && silent_) return {fmt::format("{}, {}", why, By("meanwhile flown", *silent_)), false};
  return {outcome.empty() ? why : outcome, accomplished};
}

}  // namespace kestrel::flight
