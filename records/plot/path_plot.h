// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// Whether any row is of a flight along a path (mission/path/path_pilot.h).
bool FliesPath(const std::vector<LogRow>& rows);

// gnuplot's script of a figure: the path from above with the way that was truly flown, and against time how far
// the aircraft was from it, horizontally, in height and in yaw.
std::string PathPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                     const mission::FigureText& figure);

}  // namespace kestrel::records
