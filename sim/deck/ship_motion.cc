// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/ship_motion.h"

#include <cmath>
#include <numbers>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {

ShipResponse ResponseOf(const ShipParameters& ship, double speed_m_s, double w, double beta) {
  const double k = w * w / kGravity_m_s2, L = ship.length_m, B = ship.beam_m, T = ship.draught_m;
  const double along = std::abs(k * std::cos(beta));
  const double alpha = 1 - w * speed_m_s / kGravity_m_s2 * std::cos(beta);  // of the frequencies
  const double alpha_2 = alpha * alpha, alpha_3 = std::abs(alpha_2 * alpha);
  ShipResponse response;
  response.encounter = alpha * w;
  const double A = 2 * std::sin(k * B * alpha_2 / 2) * std::exp(-k * T * alpha_2);
  const double damping = alpha_2 > 1e-6 ? A * A / (k * B * alpha_2) : 0;
  const double f = std::hypot(1 - k * T, alpha_3 > 1e-6 ? A * A / (k * B * alpha_3) : 0);
  const double eta = 1 / std::hypot(1 - 2 * k * T * alpha_2, damping);
  const double x = along * L / 2;
  const double mean = x > 1e-3 ? std::sin(x) / x : 1;  // of the wave over the length
  // Its mean slope over the length, of which 3 (sin x - x cos x) / x^3 is left.
  const double slope = along * (x > 1e-2 ? 3 * (std::sin(x) - x * std::cos(x)) / (x * x * x) : 1);
  const double pressure = std::exp(-k * T);
  response.heave = eta * pressure * f * mean;
  response.pitch = eta * pressure * f * slope;
  const double r = std::abs(response.encounter) * ship.roll_period_s / (2 * std::numbers::pi);
  response.roll = k * std::abs(std::sin(beta)) * pressure / std::hypot(1 - r * r, 2 * ship.roll_damping * r);
  response.roll_lag = std::atan2(2 * ship.roll_damping * r, 1 - r * r);
  return response;
}

ShipInWaves::ShipInWaves(const ShipParameters& ship, const WaveParameters& waves, double heading,
                         double speed_m_s, std::uint64_t seed) {
  const double beta = WrapAngle(Radians(waves.from_deg) + std::numbers::pi - heading);
  // The elevation is a cos(w t - k x + phase) along the wave's way x: forward of the middle it is a crest later
  // where the wave runs forward. Its slope at the middle then is k a sin(w t + phase).
  const double bow = std::cos(beta) >= 0 ? 1 : -1, right = std::sin(beta) >= 0 ? 1 : -1;
  for (const Wave& wave : WavesOf(WaveSpectrum(waves), seed)) {
    const ShipResponse r = ResponseOf(ship, speed_m_s, wave.w, beta);
    const double a = wave.amplitude_m;
    // A surface that rises to the right, where the wave runs, puts the right side up.
    parts_.push_back(
        {r.encounter, wave.phase, a * r.heave, bow * a * r.pitch, -right * a * r.roll, r.roll_lag});
  }
}

ShipMotion ShipInWaves::At(double t_s) const {
  ShipMotion m;
  for (const Part& p : parts_) {
    const double angle = p.encounter * t_s + p.phase;
    m.heave_m += p.heave * std::cos(angle);
    m.pitch += p.pitch * std::sin(angle);
    m.roll += p.roll * std::sin(angle - (p.encounter >= 0 ? p.roll_lag : -p.roll_lag));
  }
  return m;
}

}  // namespace kestrel::sim
