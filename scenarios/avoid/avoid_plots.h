// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// gnuplot's script of a figure as thesis 6.21 to 6.23, by the truth but for what is named otherwise. Left a
// plan of the flight, north up: the path coloured by the phase of the mission, the heading at regular
// instants, the targets with marks at the same instants, the line of the course, and the circle of the least
// distance about the target that was that near. Right against time the distances, the bearings of the targets
// beside the one that was seen and the one that was to be held, and the commanded yaw rate. Of rows for which
// MeetsOthers() (scenarios/avoid/avoid_metrics.h).
std::string EncounterPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                          const mission::FigureText& figure);

}  // namespace kestrel::scenarios
