// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_physics.h"

#include <fmt/format.h>

#include <limits>

#include "sim/server/physics/ardupilot_physics.h"
#include "sim/server/physics/px4_physics.h"

namespace kestrel::flight {

std::unique_ptr<sim::PhysicsServer> MakePhysics(const std::string& kind, const std::string& address,
                                                const std::optional<int>& port,
                                                const LoadedScenario& loaded) {
  const auto make = [&]<class Server, class Parameters>(Parameters parameters) {
    parameters.address = address;
    if (port) parameters.port = *port;
    return std::make_unique<Server>(parameters, loaded.simulator.vehicle);
  };
  if (kind == "px4") return make.template operator()<sim::Px4Physics>(sim::Px4PhysicsParameters{});
  return make.template operator()<sim::ArduPilotPhysics>(sim::ArduPilotPhysicsParameters{});
}

void ServePhysics(const LoadedScenario& loaded, sim::PhysicsServer& server,
                  const std::function<void(const vision::Frame&)>& publish,
                  const std::function<void(const std::string&)>& say) {
  sim::SimulatorParameters parameters = loaded.simulator;
  parameters.start.on_ground = true;
  parameters.start.settle_s = 1;
  // It ends with the autopilot, or the server: an aircraft in the air is not put back to its start.
  parameters.duration_s = std::numeric_limits<double>::infinity();
  const auto waits = [&] {
    say("waits for an autopilot");
    return server.Begin();
  };
  for (int flight = 1; waits(); ++flight) {
    say(fmt::format("flight {}: an autopilot is there", flight));
    sim::Simulator simulator(parameters);
    simulator.FlyBy(&server);
    while (const auto frame = simulator.Next())
      if (publish) publish(*frame);
    const sim::PhysicsCounts counts = server.counts();
    say(fmt::format("flight {}: over after {:.1f} s; {} answers, {} repeated, {} refused", flight,
                    simulator.truth().t_s, counts.answers, counts.repeated, counts.refused));
  }
}

}  // namespace kestrel::flight
