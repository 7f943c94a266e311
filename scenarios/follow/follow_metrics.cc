// SPDX-License-Identifier: Apache-2.0
#include "scenarios/follow/follow_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "scenarios/follow/follow_report.h"

namespace kestrel::scenarios {
namespace {

constexpr double kSettling_s = 4;
constexpr double kSettled = 0.05;

// Rows over which the same image was wanted: [first, last).
struct Stretch {
  std::size_t first, last;
  control::SphereImage wanted;
  double focal_px;
};

// By the last word of the mission, also while the balloon is lost.
std::vector<Stretch> StretchesOf(const std::vector<records::LogRow>& rows) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto* sight = SightOf(rows[i].decision);
    if (sight && (stretches.empty() || stretches.back().wanted.Vector() != sight->wanted.Vector()))
      stretches.push_back({i, i, sight->wanted, sight->focal_px});
    if (!stretches.empty()) stretches.back().last = i + 1;
  }
  return stretches;
}

control::SphereImage TrueImage(const Truth& truth) {
  return control::SphereImageOf(truth.targets.front().p_V, truth.targets.front().diameter_m);
}

void AddStepOfU(const std::vector<records::LogRow>& rows, const Stretch& before, const Stretch& after,
                double& settle_s, double& overshoot) {
  const double step = after.wanted.s.x() - before.wanted.s.x();
  double settled_s = rows[after.first].now.t_s, farthest = 0;
  for (std::size_t i = after.first; i < after.last; ++i) {
    const double beyond = (TrueImage(rows[i].now).s.x() - after.wanted.s.x()) / step;  // -1 at the beginning
    farthest = std::max(farthest, beyond);
    if (std::abs(beyond) > kSettled)
      settled_s = i + 1 < after.last ? rows[i + 1].now.t_s : std::numeric_limits<double>::infinity();
  }
  settle_s = std::max(settle_s, settled_s - rows[after.first].now.t_s);
  overshoot = std::max(overshoot, farthest);
}

}  // namespace

std::vector<mission::TelemetryColumn> FollowColumns() {
  const auto column = [](const char* name, auto get) {
    return mission::TelemetryColumn{name, [get](const records::LogRow& row) -> std::optional<double> {
                                      const BalloonSight* sight = SightOf(row.decision);
                                      return sight ? std::optional(get(*sight) * sight->focal_px)
                                                   : std::nullopt;
                                    }};
  };
  return {column("balloon_u_px", [](const BalloonSight& s) { return s.now.s.x(); }),
          column("balloon_v_px", [](const BalloonSight& s) { return s.now.s.y(); }),
          column("balloon_diameter_px", [](const BalloonSight& s) { return s.now.diameter; }),
          column("wanted_u_px", [](const BalloonSight& s) { return s.wanted.s.x(); }),
          column("wanted_v_px", [](const BalloonSight& s) { return s.wanted.s.y(); }),
          column("wanted_diameter_px", [](const BalloonSight& s) { return s.wanted.diameter; })};
}

std::vector<mission::Metric> FollowMetrics() {
  return {{"in_view_share", "1", "Share of the frames with the balloon's centre in the image", 0, 1},
          {"followed_share", "1", "Share of the frames in which the mission followed the balloon", 0, 1},
          {"follow_u_rms_px", "px",
           "RMS of the balloon's u off what was wanted, from 4 s after each change of that"},
          {"follow_v_rms_px", "px",
           "RMS of the balloon's v off what was wanted, from 4 s after each change of that"},
          {"follow_distance_rms", "1",
           "RMS of the distance off what was wanted, as a share of that, from 4 s after each change of it"},
          {"step_u_settle_s", "s",
           "Longest time after a change of the wanted u until u stays within 5 % of the change"},
          {"step_u_overshoot", "1",
           "Farthest that u went beyond a change of the wanted u, as a share of the change"},
          {"step_distance_error", "1",
           "Worst mean error of the distance over the second half of the time after a change of the wanted "
           "diameter, as a share of the distance wanted"}};
}

void AddFollowMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& m) {
  const std::vector<Stretch> stretches = StretchesOf(rows);
  if (stretches.empty() || rows.front().now.targets.empty()) return;
  double in_view = 0, followed = 0;
  for (const records::LogRow& row : rows)
    in_view += row.exposure.targets.front().in_view, followed += SightOf(row.decision) != nullptr;
  m["in_view_share"] = in_view / static_cast<double>(rows.size());
  m["followed_share"] = followed / static_cast<double>(rows.size());

  std::vector<double> u, v, distance;
  double settle_s = 0, overshoot = 0, distance_error = 0;
  bool u_steps = false, diameter_steps = false;
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const Stretch& s = stretches[k];
    std::vector<double> late;
    for (std::size_t i = s.first; i < s.last; ++i) {
      const Truth& now = rows[i].now;
      const control::SphereImage image = TrueImage(now);
      const double off = s.wanted.diameter / image.diameter - 1;  // of the distance
      if (i >= (s.first + s.last) / 2) late.push_back(off);
      if (now.t_s < rows[s.first].now.t_s + kSettling_s) continue;
      u.push_back(s.focal_px * (image.s.x() - s.wanted.s.x()));
      v.push_back(s.focal_px * (image.s.y() - s.wanted.s.y()));
      distance.push_back(off);
    }
    if (k == 0) continue;
    const Stretch& before = stretches[k - 1];
    if (before.wanted.s.x() != s.wanted.s.x()) {
      u_steps = true;
      AddStepOfU(rows, before, s, settle_s, overshoot);
    }
    if (before.wanted.diameter != s.wanted.diameter) {
      diameter_steps = true;
      distance_error = std::max(distance_error, std::abs(Mean(late)));
    }
  }
  if (!u.empty()) {
    m["follow_u_rms_px"] = Rms(u), m["follow_v_rms_px"] = Rms(v);
    m["follow_distance_rms"] = Rms(distance);
  }
  if (u_steps) m["step_u_settle_s"] = settle_s, m["step_u_overshoot"] = overshoot;
  if (diameter_steps) m["step_distance_error"] = distance_error;
}

}  // namespace kestrel::scenarios
