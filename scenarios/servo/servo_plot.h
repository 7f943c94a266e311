// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "mission/log_row.h"

namespace kestrel::scenarios {

bool HasServoed(const std::vector<mission::LogRow>& rows);
// The ways of the corners in the image that the law sees; height and distance from the goal; the error.
std::string ServoPlot(const std::filesystem::path& file, const std::vector<mission::LogRow>& rows,
                      const mission::FigureText& figure);

}  // namespace kestrel::scenarios
