// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "control/autopilot.h"
#include "control/sighting.h"

namespace kestrel::control {

// What is known of the far end before and in flight. Ages in s, on the monotonic clock.
struct LinkHealth {
  bool open = false;                  // the session that the protocol has, if any, is there
  std::optional<double> state_age_s;  // since the newest state was received; none: none yet
  std::optional<bool> pilot_allows;   // his switch is where setpoints are followed; none: not told
  std::uint64_t received = 0;         // messages that were taken
  std::uint64_t refused = 0;          // that were damaged, unknown, doubled or out of order
  std::uint64_t sent = 0;             // setpoints
  bool simulated = false;  // the far end says so of its aircraft; false: it does not, or its wire cannot
  std::string error;       // empty: none. Otherwise what is the matter, in words
};

// An autopilot behind a real wire. A thread of its own listens, keeps the session alive, and sends the newest
// setpoint as often as the protocol needs it; the functions return at once and may be called from any thread.
//
// VehicleState::t_s is the monotonic clock of this computer (base/clock_sync.h), as are the times of
// a LiveCamera's frames. Before the first state it is a VehicleState{}, whose age LinkHealth tells.
//
// A setpoint that the protocol cannot express is not sent, and is an error by name. What was sent is repeated
// for kRepeat_s after Send at most: then the wire falls silent, and the autopilot's own time-out acts.
class AutopilotLink : public Autopilot {
 public:
  static constexpr double kRepeat_s = 0.25;

  virtual LinkHealth Health() const = 0;
  // Nothing more is sent as a setpoint until the next Send(). (Keeping the session alive goes on.)
  virtual void Silence() = 0;
  // What the camera saw, for an autopilot that flies by it itself. Wires without such a message pass it over.
  virtual void See(const Sighting&) {}
};

}  // namespace kestrel::control
