// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

// Whether the fuzzy law said how fast to descend in any of the rows.
bool DescendsByRules(const std::vector<records::LogRow>& rows);

// gnuplot's script of a figure of the fuzzy law: the membership functions of its inputs and its output, in the
// units of the flight, and the velocity that it commands over both inputs, with what it was asked in this
// flight.
std::string DescentPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                        const mission::FigureText& figure);

}  // namespace kestrel::scenarios
