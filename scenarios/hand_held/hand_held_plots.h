// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// Whether the landmark was seen in any of the rows.
bool SawLandmark(const std::vector<records::LogRow>& rows);

// gnuplot's script of a figure as thesis 3.8 to 3.11: the camera's place in the room and its yaw against
// time, by the motion capture, by the landmark, and by the chain of homographies alone.
std::string HandHeldPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                         const mission::FigureText& figure);

// As thesis 3.7: the way through the room from above, with the camera's heading, by both.
std::string HandHeldTrajectory(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                               const mission::FigureText& figure);

}  // namespace kestrel::scenarios
