// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace kestrel::campaign {

// Where an aircraft truly was, in N.
struct Trajectory {
  std::vector<double> t_s, north_m, east_m, height_m;
};

// Of a run's telemetry.csv, at most so many points (two or more) evenly spread, the first and the last among
// them; lines that are cut off are left out. None: there is no such file, or no whole line with these
// columns.
std::optional<Trajectory> ReadTrajectory(const std::filesystem::path& telemetry, std::size_t max_points);

}  // namespace kestrel::campaign
