// SPDX-License-Identifier: Apache-2.0
#include "scenarios/pose/pose_metrics.h"

#include <algorithm>
#include <optional>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"

namespace kestrel::scenarios {
namespace {

// The autopilot's own estimate at an exposure, between those that came with the frames. None: outside of
// them.
std::optional<Pose> EstimateAt(const std::vector<records::LogRow>& rows, double t_s) {
  const auto after = std::lower_bound(rows.begin(), rows.end(), t_s,
                                      [](const records::LogRow& row, double t) { return row.now.t_s < t; });
  if (after == rows.begin() || after == rows.end()) return std::nullopt;
  const records::LogRow &a = *(after - 1), &b = *after;
  const double share = (t_s - a.now.t_s) / (b.now.t_s - a.now.t_s);
  return Pose{a.estimate.R_NB.slerp(share, b.estimate.R_NB),
              a.estimate.p_NB + share * (b.estimate.p_NB - a.estimate.p_NB)};
}

}  // namespace

std::vector<mission::Metric> PoseMetrics() {
  return {
      {"fix_autopilot_x_rms_m", "m", "RMS of the fix less the autopilot's own estimate, along the pad's x"},
      {"fix_autopilot_y_rms_m", "m", "RMS of the fix less the autopilot's own estimate, along the pad's y"},
      {"fix_autopilot_z_rms_m", "m", "RMS of the fix less the autopilot's own estimate, in height"},
      {"fix_autopilot_yaw_rms_deg", "deg", "RMS of the fix less the autopilot's own estimate, in yaw"}};
}

void AddPoseMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics) {
  mission::MeanSquare x, y, z, yaw;
  for (const records::LogRow& row : rows) {
    const auto X_NB = EstimateAt(rows, row.exposure.t_s);
    if (!row.decision.fix || !X_NB) continue;
    const Pose X_TB = row.exposure.X_NT.Inverse() * *X_NB;
    const Eigen::Vector3d e = row.decision.fix->p_TB - X_TB.p;
    x.Add(e.x()), y.Add(e.y()), z.Add(e.z());
    yaw.Add(Degrees(WrapAngle(row.decision.fix->yaw_TB - YawOf(X_TB.R))));
  }
  if (x.count == 0) return;
  metrics["fix_autopilot_x_rms_m"] = x.Root();
  metrics["fix_autopilot_y_rms_m"] = y.Root();
  metrics["fix_autopilot_z_rms_m"] = z.Root();
  metrics["fix_autopilot_yaw_rms_deg"] = yaw.Root();
}

}  // namespace kestrel::scenarios
