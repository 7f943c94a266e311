// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "mission/log_row.h"

namespace kestrel::records {

// The rows of a telemetry.csv, as far as it has them: nine digits of each number, and of a mission's own
// columns nothing. The truth of an exposure is between those of the rows around it; the pad is level, and
// stands where the truth of the target has it.
struct TelemetryRows {
  std::vector<mission::LogRow> rows;
  bool truth = false;           // is in it; otherwise it is of a real aircraft
  std::set<std::string> texts;  // which the rows refer to
};

// X_BC: of the camera, for the truth of its pose. Throws InputError with the file, the line and what is wrong
// there.
TelemetryRows ReadTelemetry(const std::filesystem::path& file, const Pose& X_BC);

}  // namespace kestrel::records
