// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mission/figure_text.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::mission {
struct MissionType;
}

namespace kestrel::records {

struct PlotOptions {
  std::string title;                              // of every figure: the scenario and its seed
  std::optional<Eigen::Vector2d> pad_size_m;      // along its x and y; none: no pad lies on the ground
  const mission::MissionType* mission = nullptr;  // whose own plots are drawn too; null: none
  std::vector<mission::MetricLimit> limits = {};  // of the scenario's criteria
};

// The names of all figures that there may be, those of a flight without truth (flown_plot.h) too.
std::vector<std::string> PlotNames();

// Draws the figures of a flight with the program gnuplot into an existing folder: position.png, the aircraft
// in the pad's frame, or north, east and up without one, and its yaw, against time, by the truth, the fix and
// the autopilot, and the positions that it was sent to; trajectory.png, the true flight in space with its heading and that of the fix, and what else
// flew near; error.png, of flights over a
// pad, the fix less the truth at its exposure, and the distance from the pad; and those that the type of
// the mission declares.
// Without rows there are none. Throws std::runtime_error with the folder and what gnuplot said.
void DrawPlots(const std::filesystem::path& folder, const std::vector<LogRow>& rows,
               const PlotOptions& options);

}  // namespace kestrel::records
