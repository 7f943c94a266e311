// SPDX-License-Identifier: Apache-2.0
#include "flight/served/link_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace kestrel::flight {
namespace {

constexpr double kLater_s = 1;       // after the later reaction the flight is ended
constexpr double kAlike_m_s = 0.03;  // beyond what a wire rounds off
constexpr double kStands_m_s =
    0.35;  // mean speed of an aircraft that holds its place, in wind and with gusts

const FlownEvent* FirstSafety(const WireFlown& flown, double from_s, std::string_view is_like,
                              std::string_view reaction) {
  for (const FlownEvent& e : flown.events)
    if (e.what == "safety" && e.t_s >= from_s && e.is.starts_with(is_like) &&
        e.is.find(fmt::format(", {}", reaction)) != std::string::npos)
      return &e;
  return nullptr;
}

// Mean over the last second before the end.
double LastSpeed_m_s(const WireFlown& flown) {
  double sum = 0;
  int samples = 0;
  for (const TruthSample& t : flown.truth) {
    if (t.t_s < flown.truth.back().t_s - 1) continue;
    sum += t.v_N.norm();
    ++samples;
  }
  return sum / samples;
}

}  // namespace

WireFlightOptions FlightWith(const FaultRow& row, Wire wire, std::uint64_t seed,
                             const std::filesystem::path& folder) {
  WireFlightOptions o;
  o.wire = wire;
  o.seed = seed;
  o.fault = row.fault;
  // Lower than the landing of the figures, to be sooner over; the fault falls into its descent.
  o.overrides = {"start.height_m=3", "start.scatter_m=0.5"};
  o.aircraft = {fmt::format("safety.patience_s={}", kPatience_s)};
  o.fault_after_s = RandomStream(seed, row.name).Uniform(1, 4);
  if (row.hazard != control::Hazard::kNone)
    o.end_after_s = control::SafetyLimits{}.*row.limit + kPatience_s + kLater_s;
  o.folder = folder;
  return o;
}

FaultJudgement JudgeFault(const FaultRow& row, const WireFlown& flown, const control::SafetyLimits& limits,
                          double most_error_m) {
  FaultJudgement j;
  const auto require = [&](bool ok, std::string what) {
    if (!ok) j.wrong.push_back(std::move(what));
  };
  if (!flown.fault_s) {
    j.wrong.push_back("the flight was over before the fault");
    return j;
  }
  if (row.hazard == control::Hazard::kNone) {
    require(flown.Landed(), "it did not land: " + flown.served.outcome);
    require(flown.TouchdownError_m() <= most_error_m,
            fmt::format("touched down {:.2f} m off", flown.TouchdownError_m()));
    return j;
  }
  const double limit_s = limits.*row.limit;
  const FlownEvent* first =
      FirstSafety(flown, *flown.fault_s, control::NameOf(row.hazard), control::NameOf(row.first));
  if (first) j.reaction_s = first->t_s - *flown.fault_s;
  require(first && *j.reaction_s <= limit_s + kReactionMargin_s,
          !first ? fmt::format("no '{}, {}'", control::NameOf(row.hazard), control::NameOf(row.first))
                 : fmt::format("'{}' after {:.3f} s", first->is, *j.reaction_s));
  if (!first) return j;
  const FlownEvent* later = FirstSafety(flown, first->t_s, "", control::NameOf(row.later));
  require(later && later->t_s <= *flown.fault_s + limit_s + kPatience_s + 2 * kReactionMargin_s,
          fmt::format("no '{}' in its time", control::NameOf(row.later)));
  const double later_s = later ? later->t_s : first->t_s;
  for (const FlownEvent& e : flown.events)
    require(e.what != "safety" || e.t_s <= first->t_s || e.is.find(", fly") == std::string::npos,
            fmt::format("it flew on: '{}'", e.is));

  if (row.fault == WireFault::kCameraCut) {
    // By what came over the wire: an attitude tells nothing of the velocity that it is for.
    const control::VelocitySetpoint* held = nullptr;  // what was in force when the hold was due
    bool sinks = false;
    for (const ReceivedSetpoint& heard : flown.heard) {
      const auto* velocity = std::get_if<control::VelocitySetpoint>(&heard.setpoint);
      if (!velocity) continue;
      if (heard.t_s <= *flown.fault_s + limit_s + 2 * kReactionMargin_s) held = velocity;
      if (heard.t_s > *flown.fault_s &&
          (velocity->v_H - Eigen::Vector3d(0, 0, limits.slow_m_s)).norm() < kAlike_m_s)
        sinks = true;
    }
    require(!held || held->v_H.norm() < kAlike_m_s, "the zero velocity was not heard in time");
    require(!held || sinks, "the sinking was not heard");
    double sink = 0;
    for (const TruthSample& t : flown.truth)
      if (t.t_s > later_s) sink = std::max(sink, t.v_N.z());
    require(sink > limits.slow_m_s / 2, "it did not sink");
  }
  if (row.fault == WireFault::kLinkCut) {
    const double speed_m_s = LastSpeed_m_s(flown);
    require(speed_m_s < kStands_m_s, fmt::format("it moves at {:.2f} m/s at the end", speed_m_s));
  }
  return j;
}

}  // namespace kestrel::flight
