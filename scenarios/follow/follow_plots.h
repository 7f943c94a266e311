// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// Whether a balloon was followed in any of the rows.
bool FollowsBalloon(const std::vector<records::LogRow>& rows);

// gnuplot's script of a figure as thesis 5.18, 5.19, 5.22 and 5.23: against time where the balloon's image
// was and how large, as a level camera would have had it, by the truth, by the mission and as wanted, and
// what was commanded for it. Shaded where no balloon was followed.
std::string FollowPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                       const mission::FigureText& figure);

}  // namespace kestrel::scenarios
