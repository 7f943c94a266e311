// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_physics.h"

#include <fmt/format.h>

#include <cstddef>
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

void CheckPhysicsFaults(const std::string& kind, const LoadedScenario& loaded, Mistakes& mistakes) {
  const sim::SensorParameters& sensors = loaded.simulator.sensors;
  for (std::size_t i = 0; i < sensors.attitude_faults.size(); ++i)
    mistakes.Add("--physics", fmt::format("sensors.attitude_faults.{}", i),
                 "is of the emulated autopilot's attitude; this autopilot estimates its own",
                 "valid: sensors.faults of gyro or accel");
  if (kind != "ardupilot") return;
  for (std::size_t i = 0; i < sensors.faults.size(); ++i) {
    const sim::SensorFault& fault = sensors.faults[i];
    if (fault.type == "ok" || fault.component == "gyro" || fault.component == "accel") continue;
    mistakes.Add("--physics", fmt::format("sensors.faults.{}.component", i),
                 fmt::format("{}: ArduPilot makes this sensor from the truth, so its fault cannot reach it",
                             fault.component),
                 "valid: gyro, accel; or a fault of ArduPilot's own by its SIM_ parameters");
  }
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
    parameters.step_s = server.step_s();
    say(fmt::format("flight {}: an autopilot is there{}", flight,
                    parameters.step_s ? fmt::format("; physics of {:g} Hz", 1 / *parameters.step_s) : ""));
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
