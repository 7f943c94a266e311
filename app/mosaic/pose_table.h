// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/diagnostics.h"
#include "geometry/pose.h"

namespace kestrel::app {

// The poses X_NB of an aircraft at its images: a row of a CSV file for each, in their order. Of a telemetry.csv the
// autopilot's own estimate, brought from the times at which it was given to those of the exposures, and that of the
// first image carried back; otherwise columns north_m, east_m, down_m, yaw_deg, pitch_deg and roll_deg. A row with an empty cell has none. Mistakes have
// their line.
std::vector<std::optional<Pose>> ReadPoseTable(const std::filesystem::path& file, Mistakes& mistakes);

}  // namespace kestrel::app
