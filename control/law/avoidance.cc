// SPDX-License-Identifier: Apache-2.0
#include "control/law/avoidance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kStep_deg = 5;  // between the bearings that are tried
constexpr int kPieces = 6;       // of a turn

Eigen::Vector2d Along(double angle) { return {std::cos(angle), std::sin(angle)}; }

// Closest distance to any if we turn to a heading and fly on at the same speed: straight on until the
// aircraft obeys, then the velocity goes over evenly, in pieces, and then straight on for good.
double MissOf(std::span<const Intruder> intruders, const Eigen::Vector2d& v, double heading,
              const AvoidanceOptions& o) {
  const Eigen::Vector2d after = v.norm() * Along(heading);
  const double turn = std::abs(WrapAngle(heading - std::atan2(v.y(), v.x())));
  const double over_s =
      std::max(turn / Radians(o.hold.yaw_rate_limit_deg_s), (after - v).norm() / o.acceleration_m_s2);
  double miss = std::numeric_limits<double>::infinity(), begun_s = 0;
  Eigen::Vector2d own = Eigen::Vector2d::Zero();
  const auto fly = [&](const Eigen::Vector2d& own_v, double lasting_s) {
    for (const Intruder& i : intruders) {
      const ClosestApproach approach = ApproachOf(i.p + begun_s * i.v - own, i.v - own_v);
      if (approach.after_s <= lasting_s) miss = std::min(miss, approach.distance_m);
    }
    own += lasting_s * own_v;
    begun_s += lasting_s;
  };
  fly(v, o.turn_s);
  for (int k = 0; k < kPieces; ++k) fly(v + (k + 0.5) / kPieces * (after - v), over_s / kPieces);
  fly(after, std::numeric_limits<double>::infinity());
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
  // The one that comes nearest; who does not come within the horizon counts as farther off.
  std::size_t held = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < intruders.size(); ++i) {
    const ClosestApproach approach = ApproachOf(intruders[i].p, intruders[i].v - v);
    const bool soon = approach.after_s > 0 && approach.after_s < o.horizon_s;
    const double rank = approach.distance_m + (soon ? 0 : 2 * o.safe_m);
    if (rank < nearest) nearest = rank, held = i;
  }
  const double line_of_sight = std::atan2(intruders[held].p.y(), intruders[held].p.x());
  const double azimuth = WrapAngle(line_of_sight - yaw);
  const PassingSide first = side.value_or(azimuth > 0 ? PassingSide::kLeft : PassingSide::kRight);
  const PassingSide second = first == PassingSide::kLeft ? PassingSide::kRight : PassingSide::kLeft;
  std::optional<Manoeuvre> best;
  for (double bearing_deg = o.hold.bearing_deg; bearing_deg <= o.max_bearing_deg + 1e-9;
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

}  // namespace kestrel::control
