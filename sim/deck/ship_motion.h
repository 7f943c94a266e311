// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/deck/wave_spectrum.h"

namespace kestrel::sim {

struct ShipParameters {
  double length_m = 60, beam_m = 11, draught_m = 3.2;
  double roll_period_s = 9, roll_damping = 0.12;
  double pad_forward_m = -20;
};

inline void Fields(FieldVisitor& v, ShipParameters& p) {
  v({"length_m", "length of the ship at the waterline"}, p.length_m, 5.0, 400.0);
  v({"beam_m", "its breadth"}, p.beam_m, 2.0, 80.0);
  v({"draught_m", "how deep it lies in the water"}, p.draught_m, 0.3, 25.0);
  v({"roll_period_s", "natural period of its roll"}, p.roll_period_s, 2.0, 40.0);
  v({"roll_damping", "damping ratio of its roll"}, p.roll_damping, 0.01, 1.0);
  v({"pad_forward_m", "how far forward of the ship's middle the pad lies; negative: aft of it"},
    p.pad_forward_m, -200.0, 200.0);
}

// Response of a ship to a regular wave of amplitude 1 m: amplitudes.
struct ShipResponse {
  double heave = 0;      // m, up
  double pitch = 0;      // rad
  double roll = 0;       // rad
  double roll_lag = 0;   // rad, behind the wave's slope
  double encounter = 0;  // rad/s: the wave's frequency as the ship meets it; it may be negative
};

// Heave and pitch by the closed forms of J. J. Jensen, A. E. Mansour and A. S. Olsen, "Estimation of ship motions
// using closed-form expressions", Ocean Engineering 31, 2004, of a box in deep water. Roll as a linear oscillator
// that the wave's slope drives, lessened with depth (A. R. J. M. Lloyd, "Seakeeping: Ship Behaviour in Rough
// Weather", 1989). Surge, sway and yaw are left out.
// Deviation: the factor that lessens the pressure with depth has the wave number itself and not its part along the
// ship, without which short waves from abeam would lift it.
// w: rad/s of the wave. beta: rad, direction in which it runs less the ship's heading: 0 from astern, pi from ahead.
ShipResponse ResponseOf(const ShipParameters& ship, double speed_m_s, double w, double beta);

// How a ship moves in waves about its place in still water.
struct ShipMotion {
  double heave_m = 0;          // up
  double roll = 0, pitch = 0;  // rad: right side down, bow up
};

class ShipInWaves {
 public:
  // heading: rad, clockwise from north. waves: with a spectrum.
  ShipInWaves(const ShipParameters& ship, const WaveParameters& waves, double heading, double speed_m_s,
              std::uint64_t seed);

  ShipMotion At(double t_s) const;

 private:
  struct Part {
    double encounter, phase;
    double heave, pitch, roll, roll_lag;  // amplitudes, of this wave
  };
  std::vector<Part> parts_;
};

}  // namespace kestrel::sim
