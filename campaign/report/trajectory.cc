// SPDX-License-Identifier: Apache-2.0
#include "campaign/report/trajectory.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <string>
#include <string_view>

#include "base/user_file.h"
#include "records/telemetry/csv_cells.h"

namespace kestrel::campaign {
namespace {

std::optional<double> Number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<Trajectory> ReadTrajectory(const std::filesystem::path& telemetry, std::size_t max_points) {
  constexpr std::array kNames = {"t_s", "truth_x_m", "truth_y_m", "truth_z_m"};
  std::istringstream file(ReadUserFile(telemetry, kMaxDataBytes).bytes);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  const std::string header = line;
  const std::vector<std::string_view> names = records::CsvCells(header);
  std::array<std::size_t, 4> places;
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    places[k] = std::find(names.begin(), names.end(), kNames[k]) - names.begin();
    if (places[k] == names.size()) return std::nullopt;
  }
  std::vector<std::array<double, 4>> points;
  while (std::getline(file, line)) {
    const std::vector<std::string_view> cells = records::CsvCells(line);
    if (cells.size() != names.size()) continue;
    std::array<std::optional<double>, 4> found;
    for (std::size_t k = 0; k < found.size(); ++k) found[k] = Number(cells[places[k]]);
    if (std::all_of(found.begin(), found.end(), [](const auto& each) { return each.has_value(); }))
      points.push_back({*found[0], *found[1], *found[2], *found[3]});
  }
  if (points.empty()) return std::nullopt;
  Trajectory trajectory;
  const std::size_t count = std::min(points.size(), max_points);
  for (std::size_t k = 0; k < count; ++k) {
    const auto& [t_s, x, y, z] = points[count == 1 ? 0 : k * (points.size() - 1) / (count - 1)];
    trajectory.t_s.push_back(t_s), trajectory.north_m.push_back(x);
    trajectory.east_m.push_back(y), trajectory.height_m.push_back(-z);
  }
  return trajectory;
}

}  // namespace kestrel::campaign
