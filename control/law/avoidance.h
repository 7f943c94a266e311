// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "base/yaml/fields.h"
#include "control/law/hold_bearing.h"

// What thesis 6.4 left open of see and avoid: when to begin, at which bearing to hold what moves, and when to
// end. Everything happens in the horizontal plane, seen from above: x north, y east, m and m/s.
namespace kestrel::control {

// Of two that fly on as they do. p, v: of the other, relative to us.
struct ClosestApproach {
  double after_s = 0;  // 0: they part already
  double distance_m = 0;
};
ClosestApproach ApproachOf(const Eigen::Vector2d& p, const Eigen::Vector2d& v);

struct Intruder {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  // relative to us
  Eigen::Vector2d v = Eigen::Vector2d::Zero();  // over the ground
};

struct AvoidanceOptions {
  HoldBearingGains hold;
  double max_bearing_deg = 120;
  double safe_m = 2;  // 2 R
  double clear_share = 1.25;
  double horizon_s = 6;
  double turn_s = 0.5;
  double acceleration_m_s2 = 2;
};

inline void Fields(FieldVisitor& v, AvoidanceOptions& o) {
  v({"hold", "control of the yaw rate that holds another aircraft at a bearing"}, o.hold);
  v(Renamed("max_bearing_deg", "most_bearing_deg",
            "maximum bearing off the bow at which another aircraft may be held"),
    o.max_bearing_deg, 0.0, 180.0);
  v({"safe_m", "closest distance that is allowed: whoever is predicted to come nearer is avoided"}, o.safe_m,
    0.1, 1000.0);
  v({"clear_share", "closest distance that a manoeuvre aims for and needs to end, as a multiple of safe_m"},
    o.clear_share, 1.0, 10.0);
  v({"horizon_s", "how far ahead encounters are predicted; later ones are left for later"}, o.horizon_s, 0.5,
    600.0);
  v({"turn_s", "assumed delay until the aircraft obeys a yaw rate"}, o.turn_s, 0.0, 10.0);
  v({"acceleration_m_s2", "assumed acceleration with which the velocity follows the heading"},
    o.acceleration_m_s2, 0.1, 20.0);
}

// Whether any of them would come nearer than a distance within the horizon, were we to fly at v.
bool Threatened(std::span<const Intruder> intruders, const Eigen::Vector2d& v, double distance_m,
                const AvoidanceOptions& options);

// The bearing at which to hold an intruder, the one that comes nearest within the horizon: as small as clears
// all of them, or, if none does, the one that keeps them farthest off. v: ours. side: kept once it is chosen.
// Both sides clear: the one of thesis 6.4.3, by the sign of the bearing.
struct Manoeuvre {
  std::size_t intruder = 0;  // which of them is held
  double bearing = 0;        // rad, right positive; in the heading frame
  PassingSide side = PassingSide::kLeft;
  double miss_m = 0;  // closest distance to any that is expected of it
};
// None: there are no intruders.
std::optional<Manoeuvre> PlanManoeuvre(std::span<const Intruder> intruders, const Eigen::Vector2d& v,
                                       double yaw, std::optional<PassingSide> side,
                                       const AvoidanceOptions& options);

}  // namespace kestrel::control
