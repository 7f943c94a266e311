// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// Whether any row has an attitude that was measured (mission/horizon_observer.h).
bool MeasuresAttitude(const std::vector<LogRow>& rows);

// gnuplot's script of a figure against time: roll, pitch and heading by the truth, by the camera and by the
// autopilot's own sensors, shaded where these have failed, and the camera's errors beside twice the stated sigma.
std::string HorizonPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                        const mission::FigureText& figure);

}  // namespace kestrel::records
