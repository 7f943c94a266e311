// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/state_history.h"

#include <algorithm>
#include <cmath>

#include "geometry/pose.h"

namespace kestrel::control {
namespace {

VehicleState Extrapolate(VehicleState state, double t_s) {
  const double dt = t_s - state.t_s;
  state.p_NB += dt * state.v_N;
  state.R_NB = (state.R_NB * ExpRotation(dt * state.w_B)).normalized();
  state.t_s = t_s;
  return state;
}

}  // namespace

void StateHistory::Add(const VehicleState& state) {
  if (!states_.empty() && state.t_s < states_.back().t_s) return;
  if (!states_.empty() && state.t_s == states_.back().t_s) states_.pop_back();
  states_.push_back(state);
  while (states_.front().t_s < state.t_s - length_s_) states_.pop_front();
}

std::optional<VehicleState> StateHistory::At(double t_s, double slack_s) const {
  if (states_.empty() || t_s < states_.front().t_s - slack_s || t_s > states_.back().t_s + slack_s)
    return std::nullopt;
  const auto after = std::lower_bound(states_.begin(), states_.end(), t_s,
                                      [](const VehicleState& s, double t) { return s.t_s < t; });
  if (after == states_.begin()) return Extrapolate(*after, t_s);
  if (after == states_.end()) return Extrapolate(states_.back(), t_s);
  // Between two states: each carried to the time by its own rates, weighted by nearness. At either end this
  // meets the state itself with its rates.
  const VehicleState& before = *(after - 1);
  const double w = (t_s - before.t_s) / (after->t_s - before.t_s);
  const double weight = w * w * (3 - 2 * w);
  const VehicleState from = Extrapolate(before, t_s), to = Extrapolate(*after, t_s);
  VehicleState state = weight < 0.5 ? from : to;
  state.p_NB = (1 - weight) * from.p_NB + weight * to.p_NB;
  state.v_N = (1 - w) * before.v_N + w * after->v_N;
  state.w_B = (1 - w) * before.w_B + w * after->w_B;
  state.R_NB = from.R_NB.slerp(weight, to.R_NB);
  return state;
}

}  // namespace kestrel::control
