// SPDX-License-Identifier: Apache-2.0
#include "scenarios/flight_loop.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "config/stopwatch.h"

namespace kestrel {
namespace {

void RequireNumbers(bool finite, const char* what, double t_s) {
  if (!finite) throw NotANumber(fmt::format("at {:.3f} s: {} is not a number", t_s, what));
}

void Check(const VehicleState& state, const Frame& frame) {
  RequireNumbers(std::isfinite(frame.t_s), "the frame's time", state.t_s);
  RequireNumbers(state.p_NB.allFinite(), "the autopilot's position", frame.t_s);
  RequireNumbers(state.v_N.allFinite(), "the autopilot's velocity", frame.t_s);
  RequireNumbers(state.R_NB.coeffs().allFinite(), "the autopilot's attitude", frame.t_s);
  RequireNumbers(state.w_B.allFinite(), "the autopilot's angular rate", frame.t_s);
}

void Check(const Decision& decision, double t_s) {
  if (const auto& fix = decision.fix) {
    RequireNumbers(fix->p_TB.allFinite(), "the measured position", t_s);
    RequireNumbers(std::isfinite(fix->yaw_TB), "the measured yaw", t_s);
  }
  if (decision.aid) RequireNumbers(decision.aid->R_NB.coeffs().allFinite(), "the attitude aid", t_s);
  if (!decision.setpoint) return;
  constexpr const char* kNames[] = {"the velocity setpoint", "the position setpoint",
                                    "the attitude setpoint"};
  RequireNumbers(Finite(*decision.setpoint), kNames[decision.setpoint->index()], t_s);
}

}  // namespace

std::string Fly(Camera& camera, Autopilot& autopilot, Mission& mission,
                const std::function<bool(const Frame&, const VehicleState&, const Decision&)>& record) {
  while (const auto frame = camera.Next()) {
    const VehicleState state = autopilot.State();
    Check(state, *frame);
    const auto start = std::chrono::steady_clock::now();
    Decision decision = mission.Step(*frame, state);
    decision.control_s = SecondsSince(start) - decision.vision_s;
    Check(decision, frame->t_s);
    if (decision.aid) autopilot.Aid(*decision.aid);
    if (decision.setpoint) autopilot.Send(*decision.setpoint);
    if (!record(*frame, state, decision)) break;
    if (!decision.outcome.empty()) return std::string(decision.outcome);
  }
  return {};
}

}  // namespace kestrel
