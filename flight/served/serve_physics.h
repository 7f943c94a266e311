// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "flight/simulated/scenario.h"
#include "records/telemetry/flight_log.h"
#include "sim/server/physics/physics_server.h"

namespace kestrel::flight {

// "px4" or "ardupilot", listening at an address; port: none for its usual one. Throws std::runtime_error.
std::unique_ptr<sim::PhysicsServer> MakePhysics(const std::string& kind, const std::string& address,
                                                const std::optional<int>& port, const LoadedScenario& loaded);

// Faults that the scenario has and that cannot reach an autopilot of this kind: ArduPilot's JSON interface
// has no fields for GPS, barometer and compass, and neither kind takes an attitude.
void CheckPhysicsFaults(const std::string& kind, const LoadedScenario& loaded, Mistakes& mistakes);

struct PhysicsOptions {
  std::function<void(const vision::Frame&)> publish =
      {};                                            // each frame when it is due; none: nobody sees them
  std::function<void(const std::string&)> say = {};  // what happens
  std::optional<std::filesystem::path> folder = {};  // of the first flight's records; none: none are written
  bool video = true;                                 // among them
  std::function<bool()> stopped = [] { return false; };  // the server was, from outside
  // A flight is over; folder: of its records, if it has any.
  std::function<void(const records::Summary&, const std::optional<std::filesystem::path>& folder)> over = {};
};

struct PhysicsFlight {
  records::Summary summary;
  bool flown = false;  // it left the ground
};

// Lets autopilots of software in the loop fly the scenario's aircraft, one flight after the other, each from
// the ground, until the server is stopped, or a flight breaks off. A flight lasts until its autopilot leaves or
// begins anew, however long the scenario's own is. No time passes without the autopilot: it flies at its pace, and
// is waited for. The records of a further flight have the folder with -2, -3 behind it.
//
// It is judged by the truth (flight/served/truth_judgement.h). Its outcome is "landed", "the autopilot left" or "ended
// from outside"; "not flown" if the aircraft never left the ground, and it has not passed then. What the autopilot
// estimates is not told: the rows have no estimate, but whether the aircraft stands. Throws as RunFlight does.
std::vector<PhysicsFlight> ServePhysics(const LoadedScenario& loaded, sim::PhysicsServer& server,
                                        const PhysicsOptions& options);

// 0: all flights that left the ground have met the criteria that the truth can judge; 1: one has not, or none left
// it; 3: one broke off.
int StatusOf(const std::vector<PhysicsFlight>& flights);

}  // namespace kestrel::flight
