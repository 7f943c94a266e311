// SPDX-License-Identifier: Apache-2.0
#include "mission/path/path_records.h"

#include <optional>

#include "base/file/model_files.h"
#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"
#include "mission/path/path_pilot.h"

namespace kestrel::mission {
namespace {

template <class Get>
TelemetryColumn ReferenceColumn(const char* name, Get get) {
  return {name, [get](const LogRow& row) -> std::optional<double> {
            const auto* report = ReportOf<PathReport>(row.decision);
            if (!report || !report->reference) return std::nullopt;
            return get(*report->reference);
          }};
}

}  // namespace

std::vector<TelemetryColumn> PathColumns() {
  using Reference = WaypointPath::Reference;
  return {ReferenceColumn("path_x_m", [](const Reference& r) { return r.p_N.x(); }),
          ReferenceColumn("path_y_m", [](const Reference& r) { return r.p_N.y(); }),
          ReferenceColumn("path_z_m", [](const Reference& r) { return r.p_N.z(); }),
          ReferenceColumn("path_yaw_deg", [](const Reference& r) { return Degrees(WrapAngle(r.yaw)); })};
}

std::vector<Metric> PathMetrics() {
  return {{"path_horizontal_rmse_m", "m", "RMS distance from the path, horizontally"},
          {"path_vertical_rmse_m", "m", "RMS distance from the path, in height"},
          {"path_yaw_rmse_deg", "deg", "RMS error of the yaw that the path asks for"}};
}

void AddPathMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics) {
  MeanSquare level, height, yaw;
  for (const LogRow& row : rows) {
    const auto* report = ReportOf<PathReport>(row.decision);
    if (!report || !report->reference) continue;
    const Eigen::Vector3d e = row.now.X_NB.p - report->reference->p_N;
    level.Add(e.head<2>().norm()), height.Add(e.z());
    yaw.Add(Degrees(WrapAngle(YawOf(row.now.X_NB.R) - report->reference->yaw)));
  }
  if (level.count == 0) return;
  metrics["path_horizontal_rmse_m"] = level.Root();
  metrics["path_vertical_rmse_m"] = height.Root();
  metrics["path_yaw_rmse_deg"] = yaw.Root();
}

void CheckPathLimits(const PathParameters& path, const AircraftLimits& limits, const Place& where,
                     Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.path.speed_m_s", path.speed_m_s, limits.speed_m_s, "autopilot.speed_limit_m_s");
  most("flight.path.acceleration_m_s2", path.acceleration_m_s2, limits.acceleration_m_s2,
       "autopilot.acceleration_limit_m_s2");
  most("flight.path.yaw_rate_deg_s", path.yaw_rate_deg_s, limits.yaw_rate_deg_s,
       "autopilot.yaw_rate_limit_deg_s");
}

}  // namespace kestrel::mission
