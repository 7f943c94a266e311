// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/deck.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {

void CheckDeck(const DeckParameters& deck, double aircraft_speed_m_s, double aircraft_acceleration_m_s2,
               const Place& where, Mistakes& mistakes) {
  if (deck.motion != "still" && deck.speed_m_s >= aircraft_speed_m_s)
    mistakes.Add(
        where, "deck.speed_m_s",
        fmt::format("{:g}, but the aircraft flies at {:g} m/s at most (autopilot.speed_limit_m_s) and never "
                    "comes up with it",
                    deck.speed_m_s, aircraft_speed_m_s),
        fmt::format("valid: below {:g}, or an aircraft that is faster", aircraft_speed_m_s));
  const bool bends = deck.motion != "still" && deck.motion != "straight";
  const double bend = deck.speed_m_s * deck.speed_m_s / deck.radius_m;
  if (bends && bend > aircraft_acceleration_m_s2)
    mistakes.Add(where, "deck.radius_m",
                 fmt::format("{:g} at {:g} m/s asks for {:.3g} m/s^2, and the aircraft gives {:g} "
                             "(autopilot.acceleration_limit_m_s2)",
                             deck.radius_m, deck.speed_m_s, bend, aircraft_acceleration_m_s2),
                 fmt::format("valid: from {:.3g} on, or a slower deck",
                             deck.speed_m_s * deck.speed_m_s / aircraft_acceleration_m_s2));
  if (!deck.waves) return;
  const WaveParameters& waves = *deck.waves;
  if (waves.spectrum == "none")
    mistakes.Add(where, "deck.waves.spectrum",
                 "none, so that nothing says how the waves' height is spread over periods",
                 "valid: bretschneider, jonswap, pierson_moskowitz, or waves: null for still water");
  if (waves.sea_state == 1)
    mistakes.Add(where, "deck.waves.sea_state", "1 has no waves to speak of",
                 "valid: 2 to 6, or 0 with height_m");
  if (waves.sea_state == 0 && waves.height_m <= 0)
    mistakes.Add(where, "deck.waves.height_m", "0, and there is no sea state that gives it",
                 "valid: a height over 0, or sea_state from 2 to 6");
  if (waves.spectrum == "pierson_moskowitz" && waves.peak_s > 0)
    mistakes.Add(where, "deck.waves.peak_s",
                 fmt::format("{:g}, but that of pierson_moskowitz follows from its height", waves.peak_s),
                 "valid: 0, or the spectrum bretschneider, which has both");
  const bool needs_period = waves.spectrum == "bretschneider" || waves.spectrum == "jonswap";
  if (needs_period && waves.sea_state == 0 && waves.peak_s <= 0)
    mistakes.Add(where, "deck.waves.peak_s", "0, and there is no sea state that gives it",
                 "valid: a period over 0, or sea_state from 2 to 6");
}

Deck::Deck(const DeckParameters& p, const Pose& X_NT, std::uint64_t seed, double t_s, double dt_s)
    : height_m_(-X_NT.p.z()),
      pad_yaw_(YawOf(X_NT.R)),
      path_(p, X_NT.p.head<2>(), pad_yaw_, seed),
      t_s_(t_s - 2 * dt_s),
      dt_s_(dt_s) {
  if (p.waves) {
    forward_m_ = p.ship.pad_forward_m;
    const double speed_m_s = p.motion == "still" ? 0 : p.speed_m_s;
    ship_.emplace(p.ship, *p.waves, pad_yaw_, speed_m_s, seed);
  }
  at_ = ahead_ = PoseAt(t_s_);
  for (int i = 0; i < 3; ++i) Step();
}

// On a ship the pad turns with it about its middle at the waterline.
Pose Deck::PoseAt(double t_s) const {
  const double heading = path_.heading();
  const Eigen::Vector3d place_N(path_.p_N().x(), path_.p_N().y(), 0), pad_S(forward_m_, 0, -height_m_);
  if (!ship_) return {HeadingRotation(heading), place_N + Eigen::Vector3d(0, 0, -height_m_)};
  const ShipMotion m = ship_->At(t_s);
  const Eigen::Quaterniond R_NS(RotationFromTaitBryan({heading, m.pitch, m.roll}));
  const Eigen::Vector3d middle_N = place_N - HeadingRotation(heading) * Eigen::Vector3d(forward_m_, 0, 0);
  return {R_NS, middle_N + Eigen::Vector3d(0, 0, -m.heave_m) + R_NS * pad_S};
}

void Deck::Step() {
  before_ = at_;
  at_ = ahead_;
  t_s_ += dt_s_;
  path_.Step(t_s_, dt_s_);
  ahead_ = PoseAt(t_s_);
  const Eigen::Vector3d turn = LogRotation(ahead_.R * at_.R.conjugate()) / dt_s_,
                        turned = LogRotation(at_.R * before_.R.conjugate()) / dt_s_;
  now_.X_NT = at_;
  now_.v_N = (ahead_.p - before_.p) / (2 * dt_s_);
  now_.w_N = (turn + turned) / 2;
  now_.a_N = (ahead_.p - 2 * at_.p + before_.p) / (dt_s_ * dt_s_);
  now_.dw_N = (turn - turned) / dt_s_;
}

}  // namespace kestrel::sim
