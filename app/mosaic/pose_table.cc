// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/pose_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "records/telemetry/csv_cells.h"

namespace kestrel::app {
namespace {

constexpr std::array kPoseColumns = {"north_m", "east_m", "down_m", "yaw_deg", "pitch_deg", "roll_deg"};
constexpr std::array kTelemetryColumns = {"estimate_x_m",     "estimate_y_m",       "estimate_z_m",
                                          "estimate_yaw_deg", "estimate_pitch_deg", "estimate_roll_deg"};

constexpr double kMost_m = 1e5, kMost_deg = 360;  // of a pose

std::vector<std::string_view> LinesOf(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return lines;
}

std::optional<double> NumberIn(std::string_view cell) {
  const std::string text(cell);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

struct Timed {
  double given_s, exposed_s;
  std::optional<Pose> pose;
};

// Where a track of poses was at a time within it, or before it by no more than its first two rows are apart: the first
// image is exposed before anything is known of it.
std::optional<Pose> At(const std::vector<Timed>& rows, double t_s) {
  auto after = std::lower_bound(rows.begin(), rows.end(), t_s,
                                [](const Timed& row, double t) { return row.given_s < t; });
  if (after == rows.end()) return std::nullopt;
  if (after == rows.begin()) {
    if (after->given_s == t_s) return after->pose;
    if (rows.size() < 2 || t_s < 2 * rows[0].given_s - rows[1].given_s) return std::nullopt;
    ++after;
  }
  const Timed &a = *std::prev(after), &b = *after;
  if (!a.pose || !b.pose) return std::nullopt;
  const double share = (t_s - a.given_s) / (b.given_s - a.given_s);
  return Pose{a.pose->R.slerp(share, b.pose->R), a.pose->p + share * (b.pose->p - a.pose->p)};
}

}  // namespace

std::vector<std::optional<Pose>> ReadPoseTable(const std::filesystem::path& file, Mistakes& mistakes) {
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) {
    mistakes.Add(file.string(), "", content.error,
                 "valid: a CSV file of poses, or the telemetry.csv of a flight");
    return {};
  }
  const std::vector<std::string_view> lines = LinesOf(content.bytes);
  const std::vector<std::string_view> header =
      lines.empty() ? std::vector<std::string_view>() : records::CsvCells(lines[0]);
  const auto column = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  const bool telemetry = column("exposure_t_s") < header.size();
  const auto& names = telemetry ? kTelemetryColumns : kPoseColumns;
  std::array<std::size_t, 6> columns{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    columns[i] = column(names[i]);
    if (columns[i] == header.size())
      mistakes.Add(Place(file.string(), 1), names[i], "no such column",
                   fmt::format("valid: {}", fmt::join(kPoseColumns, ",")));
  }
  const std::size_t given = column("t_s"), exposed = column("exposure_t_s");
  if (telemetry && given == header.size()) mistakes.Add(Place(file.string(), 1), "t_s", "no such column");
  if (!mistakes.empty()) return {};
  std::vector<Timed> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const std::vector<std::string_view> cells = records::CsvCells(lines[i]);
    const auto line = static_cast<int>(i) + 1;
    if (cells.size() != header.size()) {
      mistakes.Add(Place(file.string(), line), "",
                   fmt::format("has {} cells, and its header {}", cells.size(), header.size()));
      return {};
    }
    Timed row{};
    std::array<double, 6> numbers{};
    bool whole = true;
    const auto read = [&](std::size_t at, std::string_view name, double& value) {
      if (cells[at].empty()) return whole = false;
      const auto number = NumberIn(cells[at]);
      if (!number)
        mistakes.Add(Place(file.string(), line), name, fmt::format("'{}' is no number", cells[at]));
      value = number.value_or(0);
      return number.has_value();
    };
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (!read(columns[k], names[k], numbers[k]) && !mistakes.empty()) return {};
      const double most = k < 3 ? kMost_m : kMost_deg;
      if (std::abs(numbers[k]) <= most) continue;
      mistakes.Add(Place(file.string(), line), names[k],
                   fmt::format("'{}' is no place or attitude of an aircraft", cells[columns[k]]),
                   fmt::format("valid: {:g} to {:g}", -most, most));
      return {};
    }
    if (telemetry && (!read(given, "t_s", row.given_s) || !read(exposed, "exposure_t_s", row.exposed_s)) &&
        !mistakes.empty())
      return {};
    if (whole)
      row.pose = Pose{Eigen::Quaterniond(RotationFromTaitBryan(
                          {Radians(numbers[3]), Radians(numbers[4]), Radians(numbers[5])})),
                      {numbers[0], numbers[1], numbers[2]}};
    rows.push_back(row);
  }
  std::vector<std::optional<Pose>> poses;
  for (const Timed& row : rows) poses.push_back(telemetry ? At(rows, row.exposed_s) : row.pose);
  return poses;
}

}  // namespace kestrel::app
