// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/avoid_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/tait_bryan.h"
#include "scenarios/avoid/avoid_report.h"

namespace kestrel::scenarios {
namespace {

const double kThesisBearing = Radians(50);  // 6.4.3

double NearestNow(const Truth& truth) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const TargetTruth& target : truth.targets)
    nearest = std::min(nearest, (target.p_N - truth.X_NB.p).norm());
  return nearest;
}

}  // namespace

bool MeetsIntruders(const std::vector<records::LogRow>& rows) {
  const bool avoids = std::any_of(rows.begin(), rows.end(), [](const records::LogRow& r) {
    return r.decision.phase == "cruise" || r.decision.phase == "avoid";
  });
  return avoids && !rows.front().now.targets.empty();
}

Closest ClosestOf(const std::vector<records::LogRow>& rows) {
  Closest closest;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Truth& from = rows[k].now;
    const Truth& to = k + 1 < rows.size() ? rows[k + 1].now : from;
    for (std::size_t i = 0; i < from.targets.size(); ++i) {
      const Eigen::Vector3d a = from.targets[i].p_N - from.X_NB.p, b = to.targets[i].p_N - to.X_NB.p;
      const Eigen::Vector3d moved = b - a;
      const double length2 = moved.squaredNorm();
      const double share = length2 > 0 ? std::clamp(-a.dot(moved) / length2, 0.0, 1.0) : 0;
      const double distance = (a + share * moved).norm();
      if (distance >= closest.distance_m) continue;
      const Eigen::Vector3d target_N =
          from.targets[i].p_N + share * (to.targets[i].p_N - from.targets[i].p_N);
      closest = {distance, from.t_s + share * (to.t_s - from.t_s), i, target_N};
    }
  }
  return closest;
}

std::vector<mission::TelemetryColumn> AvoidColumns() {
  const auto column = [](const char* name, auto get) {
    return mission::TelemetryColumn{name, [get](const records::LogRow& row) -> std::optional<double> {
                                      const Encounter* encounter = EncounterOf(row.decision);
                                      return encounter ? get(*encounter) : std::nullopt;
                                    }};
  };
  using E = Encounter;
  using Cell = std::optional<double>;
  return {column("intruder_bearing_deg", [](const E& e) { return Cell(Degrees(e.azimuth)); }),
          column("intruder_wanted_deg",
                 [](const E& e) { return e.wanted ? Cell(Degrees(*e.wanted)) : std::nullopt; }),
          column("intruder_range_m", [](const E& e) { return e.range_m; }),
          column("intruder_miss_m", [](const E& e) { return e.miss_m; }),
          column("intruder_after_s", [](const E& e) { return e.after_s; })};
}

std::vector<mission::Metric> AvoidMetrics() {
  return {
      {"closest_m", "m", "Minimum distance to any intruder, between the centres"},
      {"closest_s", "s", "When that was"},
      {"closest_share", "1",
       "Minimum distance as a share of what the thesis's bearing allows past a thing that stands still: the "
       "distance when a bearing was first held, times the sine of 50 degrees"},
      {"manoeuvred", "1", "1 if a bearing was held at all, otherwise 0", 0, 1},
      {"manoeuvre_s", "s", "When a bearing was held first"},
      {"manoeuvre_height_m", "m", "Farthest from the height at the beginning"},
      {"course_end_m", "m", "Distance from the line of the course at the end"},
      {"course_end_own_m", "m",
       "The same by the autopilot's own position, whose drift is no fault of the manoeuvre"},
      {"path_excess", "1", "Length of the path over the ground over its straight line, less 1"}};
}

void AddAvoidMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& m) {
  if (!MeetsIntruders(rows)) return;
  const Closest closest = ClosestOf(rows);
  m["closest_m"] = closest.distance_m, m["closest_s"] = closest.t_s;
  const Pose& begin = rows.front().now.X_NB;
  const Eigen::Vector2d right =
      HeadingRotation(YawOf(rows.front().estimate.R_NB)).toRotationMatrix().col(1).head<2>();
  const auto manoeuvre = std::find_if(rows.begin(), rows.end(), [](const records::LogRow& r) {
    const Encounter* encounter = EncounterOf(r.decision);
    return encounter && encounter->wanted;
  });
  m["manoeuvred"] = manoeuvre != rows.end();
  if (manoeuvre != rows.end()) {
    m["manoeuvre_s"] = manoeuvre->now.t_s;
    m["closest_share"] = closest.distance_m / (NearestNow(manoeuvre->now) * std::sin(kThesisBearing));
  }
  double length = 0, height = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Eigen::Vector3d& p = rows[k].now.X_NB.p;
    height = std::max(height, std::abs(p.z() - begin.p.z()));
    if (k > 0) length += (p - rows[k - 1].now.X_NB.p).head<2>().norm();
  }
  const Eigen::Vector2d gone = (rows.back().now.X_NB.p - begin.p).head<2>();
  m["manoeuvre_height_m"] = height;
  m["course_end_m"] = std::abs(gone.dot(right));
  m["course_end_own_m"] =
      std::abs((rows.back().estimate.p_NB - rows.front().estimate.p_NB).head<2>().dot(right));
  if (gone.norm() > 0) m["path_excess"] = length / gone.norm() - 1;
}

}  // namespace kestrel::scenarios
