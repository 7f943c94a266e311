// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// Whether any row has an image of a mosaic (mission/mosaic/mosaic_report.h).
bool MakesMosaic(const std::vector<LogRow>& rows);

// gnuplot's script of a figure against time: how a mosaic grew in images, keyframes and loops, how well each image
// agreed with it, and by how much an adjustment moved the farthest.
std::string GrowthPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                       const mission::FigureText& figure);

}  // namespace kestrel::records
