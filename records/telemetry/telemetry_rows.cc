// SPDX-License-Identifier: Apache-2.0
#include "records/telemetry/telemetry_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "records/telemetry/csv_cells.h"

namespace kestrel::records {
namespace {

using Columns = std::map<std::string, std::size_t, std::less<>>;

// The cells of a row by their names; one that is not there, or empty, is none.
class Row {
 public:
  Row(const Columns& columns, std::string_view line) : columns_(columns), cells_(CsvCells(line)) {
    if (cells_.size() != columns.size())
      throw std::runtime_error(
          fmt::format("{} cells where there are {} columns", cells_.size(), columns.size()));
  }

  std::string_view Text(std::string_view name) const {
    const auto column = columns_.find(name);
    return column == columns_.end() ? std::string_view() : cells_[column->second];
  }
  std::optional<double> Number(std::string_view name) const {
    const std::string_view text = Text(name);
    if (text.empty()) return std::nullopt;
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      throw std::runtime_error(fmt::format("{}: '{}' is no number", name, text));
    return value;
  }
  bool Flag(std::string_view name) const { return Number(name).value_or(0) != 0; }
  double Angle(const std::string& name) const { return Radians(Number(name).value_or(0)); }
  // pattern: with {} where the letters stand.
  std::optional<Eigen::Vector3d> Vector(std::string_view pattern, std::string_view letters = "xyz") const {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) {
      const auto number = Number(fmt::format(fmt::runtime(pattern), letters[static_cast<std::size_t>(i)]));
      if (!number) return std::nullopt;
      v[i] = *number;
    }
    return v;
  }
  Eigen::Quaterniond Rotation(const std::string& of) const {
    return Eigen::Quaterniond(
        RotationFromTaitBryan({Angle(of + "_yaw_deg"), Angle(of + "_pitch_deg"), Angle(of + "_roll_deg")}));
  }

 private:
  const Columns& columns_;
  std::vector<std::string_view> cells_;
};

std::optional<control::Setpoint> SetpointOf(const Row& row) {
  const double turn = row.Angle("setpoint_yaw_rate_deg_s"),
               thrust = row.Number("setpoint_thrust").value_or(0);
  if (const auto v = row.Vector("setpoint_v{}_m_s")) return control::VelocitySetpoint{*v, turn};
  if (const auto p = row.Vector("setpoint_{}_m"))
    return control::PositionSetpoint{*p, row.Angle("setpoint_yaw_deg")};
  if (row.Number("setpoint_pitch_rate_deg_s"))
    return control::RateSetpoint{
        {row.Angle("setpoint_roll_rate_deg_s"), row.Angle("setpoint_pitch_rate_deg_s"), turn}, thrust};
  if (row.Number("setpoint_pitch_deg"))
    return control::AttitudeSetpoint{row.Angle("setpoint_roll_deg"), row.Angle("setpoint_pitch_deg"), turn,
                                     thrust};
  return std::nullopt;
}

mission::LogRow RowOf(const Row& from, std::set<std::string>& texts) {
  const auto text = [&](std::string_view name) -> std::string_view {
    return *texts.emplace(from.Text(name)).first;
  };
  const auto time = [&](const char* name) {
    const auto t_s = from.Number(name);
    if (!t_s) throw std::runtime_error(fmt::format("it has no {}", name));
    return *t_s;
  };
  mission::LogRow row;
  row.sequence = static_cast<std::int64_t>(from.Number("sequence").value_or(0));
  row.now.t_s = row.estimate.t_s = time("t_s");
  row.exposure.t_s = time("exposure_t_s");
  row.decision.phase = text("phase");
  row.decision.target = text("target");
  row.decision.outcome = text("outcome");
  if (const auto p = from.Vector("truth_{}_m")) {
    row.now.X_NB = {from.Rotation("truth"), *p};
    row.now.v_N = from.Vector("truth_v{}_m_s").value_or(Eigen::Vector3d::Zero());
    row.now.w_B = from.Vector("truth_rate_{}_deg_s").value_or(Eigen::Vector3d::Zero()) * Radians(1);
    row.now.wind_N = from.Vector("wind_{}_m_s", "ned").value_or(Eigen::Vector3d::Zero());
    row.now.touching = from.Flag("truth_touching");
  }
  const auto estimate = from.Vector("estimate_{}_m");
  row.heard = estimate && !from.Text("mode").empty();
  if (estimate) {
    row.estimate.p_NB = *estimate;
    row.estimate.v_N = from.Vector("estimate_v{}_m_s").value_or(Eigen::Vector3d::Zero());
    row.estimate.R_NB = from.Rotation("estimate");
  }
  if (const auto fix = from.Vector("fix_{}_m")) {
    row.decision.fix.emplace();
    row.decision.fix->p_TB = *fix;
    row.decision.fix->yaw_TB = from.Angle("fix_yaw_deg");
  }
  row.decision.setpoint = SetpointOf(from);
  return row;
}

// The pose at a time between those of two rows, or at the nearer end.
Pose At(const std::vector<mission::LogRow>& rows, double t_s) {
  const auto after = std::lower_bound(rows.begin(), rows.end(), t_s,
                                      [](const mission::LogRow& row, double t) { return row.now.t_s < t; });
  if (after == rows.begin()) return rows.front().now.X_NB;
  if (after == rows.end()) return rows.back().now.X_NB;
  const Truth &a = std::prev(after)->now, &b = after->now;
  const double share = b.t_s > a.t_s ? (t_s - a.t_s) / (b.t_s - a.t_s) : 1;
  return {a.X_NB.R.slerp(share, b.X_NB.R), a.X_NB.p + share * (b.X_NB.p - a.X_NB.p)};
}

}  // namespace

TelemetryRows ReadTelemetry(const std::filesystem::path& file, const Pose& X_BC) {
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) throw InputError(file.string(), content.error);
  std::istringstream lines(content.bytes);
  std::string line;
  std::getline(lines, line);
  Columns columns;
  for (const std::string_view name : CsvCells(line)) columns.emplace(name, columns.size());
  if (!columns.contains("t_s") || !columns.contains("exposure_t_s"))
    throw InputError(Place(file.string(), 1), "is no telemetry of a flight",
                     "valid: telemetry.csv of run, serve or fly");
  TelemetryRows all;
  std::vector<std::optional<std::pair<Eigen::Vector3d, double>>> targets;  // p_TB and yaw at the exposure
  for (int number = 2; std::getline(lines, line); ++number) {
    try {
      const Row row(columns, line);
      all.rows.push_back(RowOf(row, all.texts));
      const double t_s = all.rows.back().now.t_s;
      if (all.rows.size() > 1 && !(t_s >= all.rows[all.rows.size() - 2].now.t_s))
        throw std::runtime_error(fmt::format("t_s: {} is before the row above it", t_s));
      all.truth |= row.Number("truth_x_m").has_value();
      const auto p_TB = row.Vector("target_{}_m");
      targets.push_back(p_TB ? std::optional(std::pair(*p_TB, row.Angle("target_yaw_deg"))) : std::nullopt);
    } catch (const std::runtime_error& e) {
      throw InputError(Place(file.string(), number), e.what());
    }
  }
  for (std::size_t i = 0; i < all.rows.size(); ++i) {
    Truth& exposure = all.rows[i].exposure;
    exposure.X_NB = At(all.rows, exposure.t_s);
    exposure.X_NC = exposure.X_NB * X_BC;
    if (!targets[i]) continue;
    exposure.X_NT.R = HeadingRotation(YawOf(exposure.X_NB.R) - targets[i]->second);
    exposure.X_NT.p = exposure.X_NB.p - exposure.X_NT.R * targets[i]->first;
  }
  return all;
}

}  // namespace kestrel::records
