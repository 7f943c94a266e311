// SPDX-License-Identifier: Apache-2.0
#include "mission/touch_down/go_around.h"

#include <fmt/format.h>

#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

constexpr double kWaitsWithin_m = 0.5;  // above the decision height

}  // namespace

bool GoAround::Exceeded(const ExpectedTouch& expected) const {
  const double share = parameters_.share;
  return expected.tilt > share * Radians(limits_.tilt_deg) || expected.sink_m_s > share * limits_.sink_m_s ||
         expected.speed_m_s > share * limits_.speed_m_s;
}

GoAround::Advice GoAround::Ask(double t_s, double height_m, double last_look_m,
                               const ExpectedTouch& expected) {
  const bool exceeded = Exceeded(expected);
  if (exceeded) exceeded_s_ = t_s;
  if (expected.wind_m_s > limits_.wind_m_s) windy_s_ = t_s;
  if (climbing_ && height_m < parameters_.decision_m) return aborted() ? Advice::kAbort : Advice::kGoAround;
  climbing_ = false;
  if (aborted()) return Advice::kAbort;
  const bool far_above = height_m > parameters_.decision_m + kWaitsWithin_m;
  if (far_above) committed_ = false, waits_since_s_ = -1;
  if (committed_) {
    if (exceeded && height_m < last_look_m) return BreakOff();
    return Advice::kApproach;
  }
  if (height_m > parameters_.decision_m && waits_since_s_ < 0) return Advice::kApproach;
  const bool all = parameters_.wait_first || broken_off_ > 0;
  if (t_s - (all ? std::max(exceeded_s_, windy_s_) : windy_s_) >= parameters_.steady_s) {
    committed_ = true;
    waits_since_s_ = -1;
    return Advice::kApproach;
  }
  if (waits_since_s_ < 0) waits_since_s_ = t_s;
  if (t_s - waits_since_s_ < parameters_.wait_s) return Advice::kWait;
  return BreakOff();
}

GoAround::Advice GoAround::BreakOff() {
  if (!climbing_ && !aborted()) ++broken_off_;
  committed_ = false;
  climbing_ = true;
  waits_since_s_ = -1;
  return aborted() ? Advice::kAbort : Advice::kGoAround;
}

void CheckGoAround(const GoAroundParameters& parameters, double last_look_m, const std::string& last_look_key,
                   const Place& where, Mistakes& mistakes) {
  if (parameters.decision_m >= last_look_m) return;
  mistakes.Add(where, "flight.go_around.decision_m",
               fmt::format("{:g} is below {} = {:g}, where an approach may still be broken off",
                           parameters.decision_m, last_look_key, last_look_m),
               "valid: no less than that");
}

}  // namespace kestrel::mission
