// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "control/autopilot.h"
#include "sim/server/wire_counts.h"

namespace kestrel::sim {

// The far end of an AutopilotLink's wire: what a real autopilot would say and heed, on behalf of an emulated
// one. It has no thread: Serve is to be called every few milliseconds, reads what has come, hands setpoints
// to the aircraft, and sends what is due. now_s is any clock that runs in real time; time stamps on the wire
// are the aircraft's own, VehicleState::t_s.
//
// It listens on the loopback address unless told otherwise and takes commands from the peer that opened the
// session alone. None of these protocols has authentication.
class AutopilotServer {
 public:
  virtual ~AutopilotServer() = default;
  virtual void Serve(double now_s, control::Autopilot& aircraft) = 0;
  // The pilot's switch: whether setpoints are followed. True at first.
  virtual void SetPilot(bool allows) = 0;
  virtual const WireCounts& Received() const = 0;
  virtual std::string Where() const = 0;  // to connect to: "udp://127.0.0.1:2002", "serial:/dev/pts/3"
};

}  // namespace kestrel::sim
