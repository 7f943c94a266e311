// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/begin_live.h"

#include <stdexcept>
#include <utility>

#include "base/printable.h"
#include "base/process/print_note.h"
#include "flight/flight_subject.h"
#include "flight/simulated/flight_records.h"
#include "sim/gltf/scene_glb.h"

namespace kestrel::flight {

void BeginLive(Live& live, const LoadedScenario& loaded, const sim::Simulator& simulator,
               const mission::MissionParts& parts, Changes& changes, const std::string& pace_refused) {
  LiveFlight flight;
  flight.subject = SubjectOf(loaded, simulator);
  flight.subject.changeable = changes.All();
  try {
    flight.scene_glb = sim::SceneGlb(simulator.model(), sim::SeenRotors(loaded.simulator.vehicle));
  } catch (const std::runtime_error& e) {  // the flight is what it is without
    PrintNote("viewers have no scene: {}\n", Printable(e.what()));
  }
  flight.telemetry.mission = &loaded.scenario.flight.type();
  flight.messages = MessageOptionsOf(parts);
  flight.refusals.pace = pace_refused;
  if (flight.subject.changeable.empty())
    flight.refusals.change = "the scenario names nothing under `changeable`";
  else
    flight.change = [&](const std::string& key, const std::string& value) {
      return LiveAnswer{.refused = changes.Make(key, value), .t_s = simulator.truth().t_s};
    };
  live.Begin(std::move(flight));
}

}  // namespace kestrel::flight
