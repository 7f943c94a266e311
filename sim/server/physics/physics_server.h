// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/autopilot/external_autopilot.h"

namespace kestrel::sim {

// What came over the wire since the server was made.
struct PhysicsCounts {
  std::uint64_t answers = 0;   // of the autopilot, each of which let time go on
  std::uint64_t repeated = 0;  // that had come before: answered again where the protocol asks for it
  std::uint64_t refused = 0;   // damaged, nothing that is known here, or of one who did not open the session
  std::uint64_t stray_bytes = 0;  // in a stream, that belong to no message
  std::uint64_t flights = 0;      // begun
};

// A simulator as an autopilot's software in the loop sees one: it has its sensors from here and gives its
// motors' outputs back, and no time passes without it. It has no thread; all but Stop() are to be called from
// one:
//
//   while (server.Begin()) {             // an autopilot is there, for the first time or anew
//     Simulator simulator(parameters);   // on the ground: nobody holds it in the air
//     simulator.FlyBy(&server);
//     while (const auto frame = simulator.Next()) Show(*frame);
//   }
//
// It listens on the loopback address unless told otherwise, to one autopilot at a time: the one that opened
// the session. Neither protocol has authentication.
class PhysicsServer : public ExternalAutopilot {
 public:
  // Waits until an autopilot begins a flight. False: Stop() was called, or the socket is lost. A flight that
  // its caller left before it ended is over: the next one is of an autopilot that begins anew, or goes on.
  virtual bool Begin() = 0;
  // Step of the physics that this flight's autopilot asks for; none: any. To be asked once Begin() was true.
  virtual std::optional<double> step_s() const = 0;
  // Begin() and Step() return within 50 ms, false and none, and from now on at once. On any thread, or in a
  // signal's handler.
  virtual void Stop() = 0;
  virtual std::string Where() const = 0;  // to connect to: "tcp://127.0.0.1:4560"
  // The layout by which its motors turn the rotors, such as "hexa-x"; empty: none of its own.
  virtual std::string Motors() const { return {}; }
  virtual PhysicsCounts counts() const = 0;
};

}  // namespace kestrel::sim
