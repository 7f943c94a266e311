// SPDX-License-Identifier: Apache-2.0
#include "records/telemetry/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"
#include "mission/mission_type.h"

namespace kestrel::records {
namespace {

constexpr double kSettled_m = 0.15;
constexpr double kSettledFor_s = 3;
constexpr double kHoldFrom_s = 15;
constexpr int kHoldFewest = 10;  // images: the mean of fewer is chance

Eigen::Vector3d Down_B(const Eigen::Quaterniond& R_NB) { return R_NB.conjugate() * Eigen::Vector3d::UnitZ(); }

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double TiltOf(const Pose& X_NB) {
  return Degrees(std::acos(std::clamp((X_NB.R * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0)));
}

// Of the time in which the autopilot's own attitude had failed.
void AddFailure(const std::vector<LogRow>& rows, std::map<std::string, double>& m) {
  const Truth* start = nullptr;
  std::optional<double> noticed_s;
  mission::MeanSquare tilt, attitude;
  double heading = 0, height = 0, place = 0;
  for (const LogRow& row : rows) {
    if (start && row.estimate.aided && !noticed_s) noticed_s = row.now.t_s - start->t_s;
    if (!row.now.attitude_failed) continue;
    if (!start) start = &row.now;
    const Eigen::Vector3d away = row.now.X_NB.p - start->X_NB.p;
    tilt.Add(TiltOf(row.now.X_NB));
    attitude.Add(Degrees(AngleBetween(Down_B(row.now.X_NB.R), Down_B(row.estimate.R_NB))));
    heading = std::max(heading, std::abs(WrapAngle(YawOf(row.now.X_NB.R) - YawOf(start->X_NB.R))));
    height = std::max(height, std::abs(away.z()));
    place = std::max(place, away.head<2>().norm());
  }
  if (!start) return;
  m["failure_attitude_rms_deg"] = attitude.Root();
  m["failure_tilt_rms_deg"] = tilt.Root();
  m["failure_heading_worst_deg"] = Degrees(heading);
  m["failure_height_worst_m"] = height;
  m["failure_place_worst_m"] = place;
  if (noticed_s) m["failure_noticed_s"] = *noticed_s;
  m["failure_returned"] = noticed_s && !rows.back().now.attitude_failed && !rows.back().estimate.aided;
}

}  // namespace

const std::vector<mission::Metric>& CommonMetrics() {
  constexpr double kAny = -std::numeric_limits<double>::infinity();
  static const std::vector<mission::Metric> kMetrics = {
      {"fix_x_rmse_m", "m", "RMS error of the camera's fix along the pad's x axis, at the exposures"},
      {"fix_y_rmse_m", "m", "RMS error of the camera's fix along the pad's y axis, at the exposures"},
      {"fix_z_rmse_m", "m", "RMS error of the camera's fix in height over the pad, at the exposures"},
      {"fix_yaw_rmse_deg", "deg", "RMS error of the camera's fix in yaw against the pad, at the exposures"},
      {"fix_share", "1", "Share of the frames with a fix", 0, 1},
      {"longest_loss_s", "s", "Longest time without a fix, from the first one on"},
      {"settle_s", "s", "First time from which the flight stayed within 0.15 m of its goal for 3 s"},
      {"hold_horizontal_rmse_m", "m", "RMS horizontal distance from the goal, from 15 s on"},
      {"hold_vertical_rmse_m", "m", "RMS vertical distance from the goal, from 15 s on"},
      {"hold_yaw_rmse_deg", "deg", "RMS yaw off the goal's, from 15 s on"},
      {"touchdown_error_m", "m", "Distance from the pad's centre at the first touch"},
      {"touchdown_north_m", "m", "How far north of the pad's centre the first touch was", kAny},
      {"touchdown_east_m", "m", "How far east of the pad's centre the first touch was", kAny},
      {"touchdown_sink_m_s", "m/s", "Velocity into the pad at the first touch", kAny},
      {"touchdown_tilt_deg", "deg", "Angle between aircraft and pad at the first touch", 0, 180},
      {"touchdown_speed_m_s", "m/s", "Speed along the pad at the first touch"},
      {"touchdown_s", "s", "When the first touch was"},
      {"rest_error_m", "m", "Distance from the pad's centre at the end of a landing"},
      {"rest_tilt_deg", "deg", "Angle between aircraft and pad at the end of a landing", 0, 180},
      {"max_tilt_deg", "deg", "Maximum tilt of the flight", 0, 180},
      {"failure_attitude_rms_deg", "deg",
       "RMS angle between the true down and that which is flown by, while the autopilot's attitude has "
       "failed",
       0, 180},
      {"failure_tilt_rms_deg", "deg", "RMS tilt from level while the autopilot's attitude has failed", 0,
       180},
      {"failure_heading_worst_deg", "deg", "Farthest from the heading that the failure began at", 0, 180},
      {"failure_height_worst_m", "m", "Farthest from the height that the failure began at"},
      {"failure_place_worst_m", "m", "Farthest from the place that the failure began at"},
      {"failure_noticed_s", "s", "Time from the failure until the autopilot flew by another attitude"},
      {"failure_returned", "1", "1 if the autopilot did so, and flew by its own attitude again at the end", 0,
       1}};
  return kMetrics;
}

std::vector<mission::Metric> AllMetrics() {
  std::vector<mission::Metric> all = CommonMetrics();
  for (const mission::Flight& each : mission::Missions())
    for (const mission::Metric& metric : each.type().metrics)
      if (std::none_of(all.begin(), all.end(), [&](const auto& there) { return there.name == metric.name; }))
        all.push_back(metric);
  return all;
}

bool NeedsDecisions(const std::string& metric) {
  return !metric.starts_with("touchdown_") && !metric.starts_with("rest_") &&
         !metric.starts_with("failure_") && metric != "max_tilt_deg";
}

std::map<std::string, double> Metrics(const std::vector<LogRow>& rows, const std::optional<Truth>& touch,
                                      const mission::MissionType* type) {
  std::map<std::string, double> m;
  if (rows.empty()) return m;
  mission::MeanSquare x, y, z, yaw, horizontal, vertical, hold_yaw;
  int fixes = 0;
  double tilt = 0, longest_loss = 0;
  std::optional<double> last_fix_s, settled_since_s, settle_s;
  for (const LogRow& row : rows) {
    if (row.decision.fix) {
      const Pose X_TB = row.exposure.X_NT.Inverse() * row.exposure.X_NB;
      const Eigen::Vector3d e = row.decision.fix->p_TB - X_TB.p;
      x.Add(e.x()), y.Add(e.y()), z.Add(e.z());
      yaw.Add(Degrees(WrapAngle(row.decision.fix->yaw_TB - YawOf(X_TB.R))));
      ++fixes;
    }
    if (last_fix_s) longest_loss = std::max(longest_loss, row.exposure.t_s - *last_fix_s);
    if (row.decision.fix) last_fix_s = row.exposure.t_s;
    if (row.decision.goal_T) {
      const Pose X_TB = row.now.X_NT.Inverse() * row.now.X_NB;
      const Eigen::Vector3d e = X_TB.p - *row.decision.goal_T;
      if (e.norm() < kSettled_m) {
        if (!settled_since_s) settled_since_s = row.now.t_s;
        if (!settle_s && row.now.t_s - *settled_since_s >= kSettledFor_s) settle_s = settled_since_s;
      } else {
        settled_since_s.reset();
      }
      if (row.now.t_s >= kHoldFrom_s) {
        horizontal.Add(e.head<2>().norm());
        vertical.Add(e.z());
        hold_yaw.Add(Degrees(WrapAngle(YawOf(X_TB.R) - row.decision.goal_yaw_TB)));
      }
    }
    tilt = std::max(tilt, TiltOf(row.now.X_NB));
  }
  m["fix_share"] = static_cast<double>(fixes) / static_cast<double>(rows.size());
  m["max_tilt_deg"] = tilt;
  if (fixes > 0) {
    m["fix_x_rmse_m"] = x.Root(), m["fix_y_rmse_m"] = y.Root(), m["fix_z_rmse_m"] = z.Root();
    m["fix_yaw_rmse_deg"] = yaw.Root();
    m["longest_loss_s"] = longest_loss;
  }
  AddFailure(rows, m);
  if (settle_s) m["settle_s"] = *settle_s;
  if (horizontal.count >= kHoldFewest && !touch) {
    m["hold_horizontal_rmse_m"] = horizontal.Root();
    m["hold_vertical_rmse_m"] = vertical.Root();
    m["hold_yaw_rmse_deg"] = hold_yaw.Root();
  }
  if (touch) {
    const Pose X_TB = touch->X_NT.Inverse() * touch->X_NB;
    m["touchdown_s"] = touch->t_s;
    m["touchdown_error_m"] = X_TB.p.head<2>().norm();
    m["touchdown_north_m"] = touch->X_NB.p.x() - touch->X_NT.p.x();
    m["touchdown_east_m"] = touch->X_NB.p.y() - touch->X_NT.p.y();
    // Of the pad's own point below.
    const Eigen::Vector3d v_T = touch->X_NT.R.conjugate() *
                                (touch->v_N - touch->v_NT - touch->w_NT.cross(touch->X_NB.p - touch->X_NT.p));
    m["touchdown_sink_m_s"] = v_T.z();
    m["touchdown_speed_m_s"] = v_T.head<2>().norm();
    m["touchdown_tilt_deg"] = TiltOf(X_TB);
    if (rows.back().estimate.landed) {
      const Truth& end = rows.back().now;
      m["rest_error_m"] = (end.X_NT.Inverse() * end.X_NB).p.head<2>().norm();
      m["rest_tilt_deg"] = TiltOf(end.X_NT.Inverse() * end.X_NB);
    }
  }
  if (type && type->add_metrics) type->add_metrics(rows, m);
  return m;
}

}  // namespace kestrel::records
