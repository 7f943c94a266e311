// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/yaml/config.h"
#include "flight/simulated/scenario.h"

namespace kestrel::flight {

// Every metric that a run of any mission may have.
std::vector<std::string> KnownMetrics();

// Metrics under their names of earlier versions get their present ones, with a notice: those that a file names in
// its maps and lists of these keys.
void RenameFormerMetrics(Config& config, const std::vector<std::string>& keys);

// The metrics that a flight of a scenario can have if it goes as it is meant to, of all KnownMetrics(). (One
// that goes wrong may have others: a hover that hits the ground touches down.) varies: whether a key, as
// "flight.baseline", may be another than the scenario has; what depends on it is then possible.
std::vector<std::string> PossibleMetrics(
    const Scenario& scenario,
    const std::function<bool(const std::string& key)>& varies = [](const std::string&) { return false; });

}  // namespace kestrel::flight
