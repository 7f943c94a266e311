// SPDX-License-Identifier: Apache-2.0
#include "mission/mission_type.h"

#include <stdexcept>

namespace kestrel::mission {
namespace {

std::vector<Flight>& Added() {
  static std::vector<Flight> missions;
  return missions;
}

}  // namespace

HelipadPilot PilotOf(const MissionParts& parts) { return {parts.pad, parts.camera, parts.X_BC, parts.pilot}; }

void AddMission(Flight defaults) {
  for (const Flight& other : Added())
    if (other.type().name == defaults.type().name)
      throw std::logic_error("two missions are called '" + other.type().name + "'");
  Added().push_back(std::move(defaults));
}

const std::vector<Flight>& Missions() { return Added(); }

std::vector<std::string> MissionNames() {
  std::vector<std::string> names;
  for (const Flight& each : Added()) names.push_back(each.type().name);
  return names;
}

void SelectMission(const std::string& name, Flight& flight) {
  if (flight && flight.type().name == name) return;
  for (const Flight& each : Added())
    if (each.type().name == name) flight = each;
  if (!flight && !Added().empty()) flight = Added().front();
}

}  // namespace kestrel::mission
