// SPDX-License-Identifier: Apache-2.0
#include "mission/touch_down/touch_down_records.h"

#include <optional>

namespace kestrel::mission {
namespace {

template <class Get>
TelemetryColumn Column(const char* name, Get get) {
  return {name, [get](const LogRow& row) -> std::optional<double> {
            const auto* report = ReportOf<TouchDownReport>(row.decision);
            if (!report) return std::nullopt;
            return get(*report);
          }};
}

}  // namespace

std::vector<TelemetryColumn> TouchDownColumns() {
  return {Column("attempt", [](const TouchDownReport& r) { return r.attempt; }),
          Column("wind_estimate_m_s", [](const TouchDownReport& r) { return r.wind_m_s; })};
}

std::vector<Metric> TouchDownMetrics() {
  return {{"within_limits_or_aborted", "1",
           "1 if it landed within its limits of tilt, sink and speed, or aborted without a touch", 0, 1},
          {"touchdown_beyond_limits", "1", "1 if its first touch was beyond one of those limits", 0, 1},
          {"aborted", "1", "1 if it aborted", 0, 1},
          {"approaches", "1", "Number of approaches"}};
}

void AddTouchDownMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& m) {
  const TouchDownReport* report = nullptr;
  int approaches = 0;
  for (const LogRow& row : rows)
    if (const auto* of_row = ReportOf<TouchDownReport>(row.decision)) {
      report = of_row;
      approaches = of_row->attempt;
    }
  if (!report) return;
  const TouchDownLimits& limits = report->limits;
  const bool touched = m.contains("touchdown_tilt_deg");
  const bool beyond = touched && (m.at("touchdown_tilt_deg") > limits.tilt_deg ||
                                  m.at("touchdown_sink_m_s") > limits.sink_m_s ||
                                  m.at("touchdown_speed_m_s") > limits.speed_m_s);
  const bool aborted = rows.back().decision.outcome == kAborted;
  const bool landed = touched && rows.back().estimate.landed;
  m["within_limits_or_aborted"] = touched ? landed && !beyond : aborted;
  m["touchdown_beyond_limits"] = beyond;
  m["aborted"] = aborted;
  m["approaches"] = approaches;
}

}  // namespace kestrel::mission
