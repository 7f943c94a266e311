// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/begin_live.h"

#include <utility>

#include "flight/flight_subject.h"

namespace kestrel::flight {

void BeginLive(Live& live, const LoadedScenario& loaded, const sim::Simulator& simulator,
               const std::string& scene_glb, const mission::MissionParts& parts, Changes& changes,
               const FlightRecords* records, const std::string& pace_refused) {
  LiveFlight flight;
  flight.subject = SubjectOf(loaded, simulator);
  flight.subject.changeable = changes.All();
  flight.scene_glb = scene_glb;
  flight.telemetry.mission = &loaded.scenario.flight.type();
  flight.messages = MessageOptionsOf(parts);
  flight.refusals.pace = pace_refused;
  if (flight.subject.changeable.empty())
    flight.refusals.change = "the scenario names nothing under `changeable`";
  else
    flight.change = [&changes, &simulator, records](const std::string& key, const std::string& value) {
      const std::string refused = changes.Make(key, value);
      return LiveAnswer{
          .refused = refused, .t_s = simulator.truth().t_s, .again = records ? records->again() : ""};
    };
  live.Begin(std::move(flight));
}

}  // namespace kestrel::flight
