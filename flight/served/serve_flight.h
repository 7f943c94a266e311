// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "flight/simulated/runner.h"
#include "flight/simulated/scenario.h"
#include "sim/camera/pan_tilt.h"
#include "sim/server/autopilot_server.h"

namespace kestrel::flight {

struct WallClock {
  std::function<double()> now_s;            // any that runs in real time
  std::function<void(double)> sleep_until;  // a time of it
};
WallClock MonotonicClock();

struct ServeOptions {
  std::vector<sim::AutopilotServer*> servers;
  sim::PanTilt* platform = nullptr;                   // that a server turns: the camera is on it
  std::function<void(const vision::Frame&)> publish;  // when a frame's latency is over; must return at once
  std::function<void(const vision::Frame&)> publish_ground = {};  // the same of the camera on the ground
  std::optional<std::filesystem::path> folder;                    // of the records; none: nothing is written
  std::optional<double> pilot_off_at_s;         // when the pilot's switch takes the aircraft away
  std::function<void()> begun;                  // the clock runs
  std::function<void(const std::string&)> say;  // what who watches should know, as it happens
  std::function<bool()> go_on;                  // false ends the flight in good order
  WallClock clock = MonotonicClock();
  Live* live = nullptr;  // shows it to viewers, who may change it; null: nobody does
};

// Flies a scenario's aircraft in real time for whoever is on the wires, until the scenario's duration is
// over, the aircraft has landed and stood for 3 s, or go_on says so. The machine being too slow stretches
// time (base/real_time.h); say and events.log tell how much.
//
// It is judged as RunFlight does it, by the truth, but for criteria of what only the flight code knows: they
// are left out, and said. A flight that has criteria and in which no setpoint was followed is "not flown",
// and has not passed. The rows have the last setpoint that the aircraft was given, and nothing else of a
// decision.
//
// summary.metrics has more than Metrics: stretched_s, and of all servers' WireCounts setpoints_heard,
// setpoints_followed, setpoints_refused and messages_not_heeded. What is ignored is told when the first of
// its kind comes, and counted at the end. Throws as RunFlight does.
FlightResult ServeFlight(const LoadedScenario& loaded, const ServeOptions& options);

}  // namespace kestrel::flight
