// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// Draws a flight of which no truth is known, as a real aircraft's: where the camera saw it over the pad and
// how high its autopilot had it; the velocity that the mission asked for, and what was sent after the safety
// layer; roll and pitch by the autopilot. Shaded where the safety layer did not let the mission fly. Without
// rows there is none. Throws std::runtime_error with what gnuplot said.
void DrawFlownPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                   const std::string& title);

}  // namespace kestrel::records
