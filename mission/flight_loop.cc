// SPDX-License-Identifier: Apache-2.0
#include "mission/flight_loop.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "base/stopwatch.h"

namespace kestrel::mission {
namespace {

void RequireNumber(bool finite, const char* what, double t_s) {
  if (!finite) throw NotANumber(fmt::format("at {:.3f} s: {} is not a number", t_s, what));
}

}  // namespace

void RequireNumbers(const vision::Frame& frame, const control::VehicleState& state,
                    const Decision& decision) {
  const double t_s = frame.t_s;
  RequireNumber(std::isfinite(t_s), "the frame's time", state.t_s);
  RequireNumber(state.p_NB.allFinite(), "the autopilot's position", t_s);
  RequireNumber(state.v_N.allFinite(), "the autopilot's velocity", t_s);
  RequireNumber(state.R_NB.coeffs().allFinite(), "the autopilot's attitude", t_s);
  RequireNumber(state.w_B.allFinite(), "the autopilot's angular rate", t_s);
  if (const auto& fix = decision.fix) {
    RequireNumber(fix->p_TB.allFinite(), "the measured position", t_s);
    RequireNumber(std::isfinite(fix->yaw_TB), "the measured yaw", t_s);
  }
  if (decision.aid) RequireNumber(decision.aid->R_NB.coeffs().allFinite(), "the attitude aid", t_s);
  if (!decision.setpoint) return;
  constexpr const char* kNames[] = {"the velocity setpoint", "the position setpoint",
                                    "the attitude setpoint"};
  RequireNumber(control::Finite(*decision.setpoint), kNames[decision.setpoint->index()], t_s);
}

std::string Fly(
    vision::Camera& camera, control::Autopilot& autopilot, Mission& mission,
    const std::function<bool(const vision::Frame&, const control::VehicleState&, const Decision&)>& record) {
  while (const auto frame = camera.Next()) {
    const control::VehicleState state = autopilot.State();
    const auto start = std::chrono::steady_clock::now();
    Decision decision = mission.Step(*frame, state);
    decision.control_s = SecondsSince(start) - decision.vision_s;
    if (decision.aid) autopilot.Aid(*decision.aid);
    if (decision.setpoint) autopilot.Send(*decision.setpoint);
    if (!record(*frame, state, decision)) break;
    if (!decision.outcome.empty()) return std::string(decision.outcome);
  }
  return {};
}

}  // namespace kestrel::mission
