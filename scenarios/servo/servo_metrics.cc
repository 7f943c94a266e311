// SPDX-License-Identifier: Apache-2.0
#include "scenarios/servo/servo_metrics.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/servo/servo_report.h"

namespace kestrel::scenarios {
namespace {

constexpr double kStays_s = 3, kWithin_m = 0.3, kWithin_deg = 10;

}  // namespace

std::vector<mission::TelemetryColumn> ServoColumns() {
  const auto column = [](const char* name, auto get) {
    return mission::TelemetryColumn{name, [get](const mission::LogRow& row) -> std::optional<double> {
                                      const auto* report =
                                          mission::ReportOf<mission::ServoReport>(row.decision);
                                      return report ? std::optional<double>(get(*report)) : std::nullopt;
                                    }};
  };
  return {column("servo_error_px", [](const mission::ServoReport& r) { return r.error_px; }),
          column("servo_state", [](const mission::ServoReport& r) { return static_cast<double>(r.state); }),
          column("servo_conditioning", [](const mission::ServoReport& r) { return r.conditioning; }),
          column("servo_reach", [](const mission::ServoReport& r) { return r.reach; }),
          column("servo_depth_m", [](const mission::ServoReport& r) { return r.depth_m; })};
}

std::vector<mission::Metric> ServoMetrics() {
  return {{"servo_converged", "1",
           "Whether the flight was within 0.3 m and 10 degrees of its goal throughout its last 3 s", 0, 1},
          {"servo_end_m", "m", "Distance from the goal at the end"},
          {"servo_end_yaw_deg", "deg", "Yaw off the goal's at the end", 0, 180},
          {"servo_retreat_m", "m", "Largest height above both the start and the goal"},
          {"servo_advance_m", "m", "Largest depth below both the start and the goal"}};
}

void AddServoMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& m) {
  if (rows.empty() || !rows.front().decision.goal_T) return;
  const mission::LogRow& last = rows.back();
  const auto over_pad = [](const mission::LogRow& row) { return row.now.X_NT.Inverse() * row.now.X_NB; };
  const double start_m = -over_pad(rows.front()).p.z();
  double retreat = 0, advance = 0;
  bool converged = last.decision.outcome.empty() && last.now.t_s - rows.front().now.t_s >= kStays_s;
  for (const mission::LogRow& row : rows) {
    const Pose X_TB = over_pad(row);
    const double off_m = (X_TB.p - *row.decision.goal_T).norm();
    const double off_deg = Degrees(std::abs(WrapAngle(YawOf(X_TB.R) - row.decision.goal_yaw_TB)));
    const double height_m = -X_TB.p.z(), goal_m = -row.decision.goal_T->z();
    retreat = std::max(retreat, height_m - std::max(start_m, goal_m));
    advance = std::max(advance, std::min(start_m, goal_m) - height_m);
    if (row.now.t_s >= last.now.t_s - kStays_s)
      converged = converged && off_m < kWithin_m && off_deg < kWithin_deg;
    if (&row == &last) m["servo_end_m"] = off_m, m["servo_end_yaw_deg"] = off_deg;
  }
  m["servo_converged"] = converged;
  m["servo_retreat_m"] = retreat, m["servo_advance_m"] = advance;
}

}  // namespace kestrel::scenarios
