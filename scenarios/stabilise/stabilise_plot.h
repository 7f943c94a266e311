// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "mission/log_row.h"

namespace kestrel::scenarios {

// Whether any row has a stabilised image.
bool ShowsStabilised(const std::vector<mission::LogRow>& rows);

// gnuplot's script of a figure: how what is truly seen at one corner of the view moved, less its mean over two
// seconds, as it came in and stabilised, and the amplitudes of both against frequency.
std::string CornerMotionPlot(const std::filesystem::path& file, const std::vector<mission::LogRow>& rows,
                             const mission::FigureText& figure);

}  // namespace kestrel::scenarios
