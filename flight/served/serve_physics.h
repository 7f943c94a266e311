// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/diagnostics.h"
#include "flight/simulated/scenario.h"
#include "sim/server/physics/physics_server.h"

namespace kestrel::flight {

// "px4" or "ardupilot", listening at an address; port: none for its usual one. Throws std::runtime_error.
std::unique_ptr<sim::PhysicsServer> MakePhysics(const std::string& kind, const std::string& address,
                                                const std::optional<int>& port, const LoadedScenario& loaded);

// Faults that the scenario has and that cannot reach an autopilot of this kind: ArduPilot's JSON interface
// has no fields for GPS, barometer and compass, and neither kind takes an attitude.
void CheckPhysicsFaults(const std::string& kind, const LoadedScenario& loaded, Mistakes& mistakes);

// Lets autopilots of software in the loop fly the scenario's aircraft, one flight after the other, each from
// the ground, until the server is stopped. A flight lasts until its autopilot leaves or begins anew, however
// long the scenario's own is. No time passes without the autopilot: it flies at its pace, and
// is waited for. publish: each frame when it is due. say: what happens.
void ServePhysics(const LoadedScenario& loaded, sim::PhysicsServer& server,
                  const std::function<void(const vision::Frame&)>& publish,
                  const std::function<void(const std::string&)>& say);

}  // namespace kestrel::flight
