// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "sim/deck/deck_path.h"
#include "sim/deck/ship_motion.h"

// A pad on a deck that moves: driven over the ground, or on a ship in waves, or both.
namespace kestrel::sim {

struct DeckParameters : DeckPathParameters {
  double size_m = 3, friction = 0.9;
  std::string hold = "friction";
  std::optional<WaveParameters> waves;
  ShipParameters ship;
};

inline void Fields(FieldVisitor& v, DeckParameters& p) {
  v({"motion",
     "how the deck drives: straight along the pad's yaw_deg, in a circle to the right, in a figure of 8, "
     "or at random"},
    p.motion, {"still", "straight", "circle", "figure_8", "random"});
  v({"speed_m_s", "its speed over the ground or the water"}, p.speed_m_s, 0.0, 8.0);
  v({"starts_s", "when it begins to drive, in the time of the flight"}, p.starts_s, 0.0, 1e9);
  v({"acceleration_m_s2", "with which it gathers speed"}, p.acceleration_m_s2, 0.1, 10.0);
  v({"radius_m", "radius of the circle, and of the sharpest bends of the other paths"}, p.radius_m, 2.0,
    500.0);
  v({"within_m", "distance from its beginning at which a random path turns back"}, p.within_m, 5.0, 1000.0);
  v({"size_m", "side of the square plate that the pad lies on and the aircraft may stand on"}, p.size_m, 0.5,
    60.0);
  v({"friction", "coefficient of friction of the skids on it"}, p.friction, 0.05, 2.0);
  v({"hold",
     "what holds the aircraft that has touched down: friction, or fixed, as by a harpoon, 0.3 s after"},
    p.hold, {"friction", "fixed"});
  v({"waves", "waves of the sea that the deck's ship moves in; null: none"}, p.waves);
  v({"ship", "the ship, of which waves make heave, roll and pitch of the deck"}, p.ship);
}

// What each number allows and together they do not: waves without a spectrum or without a height, a period that
// goes by the height, bends that an aircraft of such limits cannot follow, a deck as fast as the aircraft.
// where: of the deck's keys.
void CheckDeck(const DeckParameters& deck, double aircraft_speed_m_s, double aircraft_acceleration_m_s2,
               const Place& where, Mistakes& mistakes);

struct DeckMotion {
  Pose X_NT;                                       // of the pad
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();   // m/s, of its origin
  Eigen::Vector3d w_N = Eigen::Vector3d::Zero();   // rad/s
  Eigen::Vector3d a_N = Eigen::Vector3d::Zero();   // m/s^2
  Eigen::Vector3d dw_N = Eigen::Vector3d::Zero();  // rad/s^2
};

// The motion, step by step.
class Deck {
 public:
  // X_NT: of the level pad at rest in still water, and where its drive begins. The first instant is t_s.
  Deck(const DeckParameters& parameters, const Pose& X_NT, std::uint64_t seed, double t_s, double dt_s);

  void Step();  // to the next instant
  const DeckMotion& now() const { return now_; }

 private:
  Pose PoseAt(double t_s) const;  // of the sea; where the path is

  double height_m_, pad_yaw_, forward_m_ = 0;
  DeckPath path_;
  std::optional<ShipInWaves> ship_;
  double t_s_, dt_s_;         // of ahead_
  Pose before_, at_, ahead_;  // one step apart
  DeckMotion now_;
};

}  // namespace kestrel::sim
