// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// The text of summary.json. Numbers that are not finite are written as null.
std::string ToJson(const Summary& summary);

// Reads it back; null is NaN. Throws std::runtime_error with the name and what is wrong.
Summary SummaryFromJson(const std::string& json, const std::string& name);
Summary ReadSummary(const std::filesystem::path& file);

// Mean and 99th percentile; zeros of none.
StageTime StageTimeOf(std::vector<double> seconds);

}  // namespace kestrel::records
