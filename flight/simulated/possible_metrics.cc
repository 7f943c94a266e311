// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/possible_metrics.h"

#include <algorithm>

#include "records/telemetry/metrics.h"
#include "scenarios/avoid/avoid_metrics.h"
#include "scenarios/follow/follow_metrics.h"

namespace kestrel {
namespace {

// Whether references differ by a field of theirs, so that there are steps of it.
bool Steps(const FollowFlight& flight, double FollowReference::*field) {
  return std::any_of(flight.reference.begin(), flight.reference.end(), [&](const FollowReference& each) {
    return each.*field != flight.reference.front().*field;
  });
}

}  // namespace

std::vector<std::string> PossibleMetrics(const Scenario& s,
                                         const std::function<bool(const std::string& key)>& varies) {
  std::vector<std::string> names = MetricNames();
  const auto keep = [&](bool possible, const auto& of) {
    if (!possible) std::erase_if(names, of);
  };
  const auto named = [](std::vector<std::string> those) {
    return [those = std::move(those)](const std::string& name) {
      return std::find(those.begin(), those.end(), name) != those.end();
    };
  };
  const auto begins = [](const char* with) {
    return [with](const std::string& name) { return name.starts_with(with); };
  };
  const bool lands = std::holds_alternative<LandingFlight>(s.flight);
  const bool hovers = std::holds_alternative<HoverFlight>(s.flight);
  const auto* attitude = std::get_if<AttitudeFlight>(&s.flight);
  const auto* follow = std::get_if<FollowFlight>(&s.flight);
  const bool steps = varies("flight.reference");

  keep(LooksForPad(s.flight),
       named({"fix_x_rmse_m", "fix_y_rmse_m", "fix_z_rmse_m", "fix_yaw_rmse_deg", "longest_loss_s"}));
  keep(hovers || lands, named({"settle_s"}));
  keep(hovers, begins("hold_"));
  keep(lands, begins("touchdown_"));
  keep(lands, begins("rest_"));
  keep(attitude || std::holds_alternative<GyroFailureFlight>(s.flight),
       named({"attitude_share", "attitude_outliers", "attitude_within_2_sigma", "roll_rmse_deg",
              "pitch_rmse_deg", "yaw_rmse_deg", "yaw_rmse_first_half_deg", "yaw_rmse_second_half_deg"}));
  keep(attitude && (attitude->baseline || varies("flight.baseline")), begins("baseline_"));
  keep(!s.sensors.attitude_faults.empty() || varies("sensors.attitude_faults"), begins("failure_"));
  keep(follow, named(FollowMetricNames()));
  keep(follow && (steps || Steps(*follow, &FollowReference::u_px)), begins("step_u_"));
  keep(follow && (steps || Steps(*follow, &FollowReference::diameter_px)), begins("step_distance_"));
  keep(std::holds_alternative<AvoidFlight>(s.flight) && !(s.targets.empty() && !varies("targets")),
       named(AvoidMetricNames()));
  return names;
}

}  // namespace kestrel
