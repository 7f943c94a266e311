// SPDX-License-Identifier: Apache-2.0
#include "control/avoidance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

constexpr double kStep_deg = 5;  // between the bearings that are tried

Eigen::Vector2d Along(double angle) { return {std::cos(angle), std::sin(angle)}; }

// Closest distance to any if we turn to a heading and fly on at the same speed: for the time of the turn at
// the mean of both velocities.
double MissOf(std::span<const Intruder> intruders, const Eigen::Vector2d& v, double heading,
              const AvoidanceOptions& o) {
  const double speed = v.norm();
  const double turn = std::abs(WrapAngle(heading - std::atan2(v.y(), v.x())));
  const Eigen::Vector2d after = speed * Along(heading), during = (v + after) / 2;
  const double turn_s = o.turn_s + std::max(turn / Radians(o.hold.yaw_rate_limit_deg_s),
                                            (after - v).norm() / o.acceleration_m_s2);
  double miss = std::numeric_limits<double>::infinity();
  for (const Intruder& i : intruders) {
    const ClosestApproach turning = ApproachOf(i.p, i.v - during);
    if (turning.after_s < turn_s) miss = std::min(miss, turning.distance_m);
    const ClosestApproach then = ApproachOf(i.p + turn_s * (i.v - during), i.v - after);
    miss = std::min(miss, then.distance_m);
  }
  return miss;
}

}  // namespace

ClosestApproach ApproachOf(const Eigen::Vector2d& p, const Eigen::Vector2d& v) {
  const double closing = -p.dot(v), speed2 = v.squaredNorm();
  if (closing <= 0 || speed2 <= 0) return {0, p.norm()};
  const double after_s = closing / speed2;
  return {after_s, (p + after_s * v).norm()};
}

bool Threatened(std::span<const Intruder> intruders, const Eigen::Vector2d& v, double distance_m,
                const AvoidanceOptions& options) {
  return std::any_of(intruders.begin(), intruders.end(), [&](const Intruder& i) {
    const ClosestApproach approach = ApproachOf(i.p, i.v - v);
    return approach.distance_m < distance_m && approach.after_s > 0 && approach.after_s < options.horizon_s;
  });
}

std::optional<Manoeuvre> PlanManoeuvre(std::span<const Intruder> intruders, const Eigen::Vector2d& v,
                                       double yaw, std::optional<PassingSide> side,
                                       const AvoidanceOptions& o) {
  if (intruders.empty()) return std::nullopt;
  // The one that comes nearest within the horizon, and among those that part already the nearest.
  std::size_t held = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < intruders.size(); ++i) {
    const ClosestApproach approach = ApproachOf(intruders[i].p, intruders[i].v - v);
    const double rank = approach.distance_m + (approach.after_s > 0 ? 0 : 2 * o.safe_m);
    if (rank < nearest) nearest = rank, held = i;
  }
  const double line_of_sight = std::atan2(intruders[held].p.y(), intruders[held].p.x());
  const double azimuth = WrapAngle(line_of_sight - yaw);
  const PassingSide first = side.value_or(azimuth > 0 ? PassingSide::kLeft : PassingSide::kRight);
  const PassingSide second = first == PassingSide::kLeft ? PassingSide::kRight : PassingSide::kLeft;
  std::optional<Manoeuvre> best;
  for (double bearing_deg = o.hold.bearing_deg; bearing_deg <= o.most_bearing_deg + 1e-9;
       bearing_deg += kStep_deg) {
    for (const PassingSide each : {first, second}) {
      if (side && each != *side) continue;
      const double bearing = Radians(each == PassingSide::kLeft ? bearing_deg : -bearing_deg);
      const double miss = MissOf(intruders, v, line_of_sight - bearing, o);
      if (miss >= o.clear_share * o.safe_m) return Manoeuvre{held, bearing, each, miss};
      if (!best || miss > best->miss_m) best = Manoeuvre{held, bearing, each, miss};
    }
  }
  return best;
}

}  // namespace kestrel
