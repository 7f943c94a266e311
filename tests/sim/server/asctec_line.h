// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <variant>
#include <vector>

#include "control/link/asctec_link.h"
#include "geometry/tait_bryan.h"
#include "sim/server/asctec_server.h"

namespace kestrel::control {

constexpr double kTick_s = 0.002;

// Says what it is told to and keeps what it hears.
class ScriptedAircraft final : public Autopilot {
 public:
  ScriptedAircraft() {
    state.landed = false;
    state.mode = FlightMode::kHold;
  }
  VehicleState State() const override { return state; }
  void Send(const Setpoint& setpoint) override { heard.push_back(setpoint); }
  void Aid(const AttitudeAid&) override { ++aids; }

  VehicleState state;
  std::vector<Setpoint> heard;
  int aids = 0;
};

// Both ends and the line between them, in a time of its own.
struct Line {
  explicit Line(const AscTecOptions& options = {}, const sim::AscTecProcessorOptions& far = {})
      : session(options), processor(far) {
    session.Opened(t_s);
  }
  void Run(
      double duration_s, Autopilot& aircraft, const std::function<void()>& each = [] {}) {
    for (const double end = t_s + duration_s - kTick_s / 2; t_s < end;) {
      t_s += kTick_s;
      wire::Bytes asked = session.Say(t_s);
      if (to_processor) to_processor(asked);
      bytes_asked += asked.size();
      processor.Receive(t_s, asked);
      wire::Bytes said = processor.Step(t_s, aircraft);
      if (to_session) to_session(said);
      bytes_said += said.size();
      session.Receive(t_s, said);
      each();
    }
  }
  // With the setpoint kept up at 20 Hz.
  void Keep(
      const Setpoint& setpoint, double duration_s, Autopilot& aircraft,
      const std::function<void()>& each = [] {}) {
    double due_s = t_s;
    Run(duration_s, aircraft, [&] {
      if (t_s >= due_s) session.Send(t_s, setpoint), due_s += 0.05;
      each();
    });
  }

  double t_s = 100;
  AscTecSession session;
  sim::AscTecProcessor processor;
  std::function<void(wire::Bytes&)> to_processor, to_session;
  std::size_t bytes_asked = 0, bytes_said = 0;
};

inline VehicleState SomeState() {
  VehicleState s;
  s.landed = false;
  s.p_NB = {12.3, -45.6, -7.8};
  s.v_N = {1.234, -0.567, 0.321};
  s.R_NB = RotationFromTaitBryan({-2.1, 0.15, -0.22});
  s.w_B = {0.3, -0.2, 0.7};
  return s;
}

template <class S>
S LastOf(const ScriptedAircraft& aircraft) {
  if (aircraft.heard.empty() || !std::holds_alternative<S>(aircraft.heard.back())) {
    ADD_FAILURE() << "no such setpoint";
    return {};
  }
  return std::get<S>(aircraft.heard.back());
}

}  // namespace kestrel::control
