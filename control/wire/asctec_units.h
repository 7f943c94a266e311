// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "base/gravity.h"
#include "control/wire/asctec.h"

// Counts of the AscTec low-level processor to SI and back. Sizes alone, no signs: which way nick, roll and
// yaw count is a matter of the vehicle (the public drivers disagree on roll) and of whoever knows the frames.
namespace kestrel::control::wire {

inline constexpr double kRadPerAngleCount = std::numbers::pi / 180 / 1000;   // ImuCalcData angles, headings
inline constexpr double kRad_sPerRateCount = std::numbers::pi / 180 / 64.8;  // ImuCalcData angvel
inline constexpr double kM_s2PerAccCount = kGravity_m_s2 / 10000;            // ImuCalcData acc
inline constexpr double kMetresPerCount = 1e-3;                              // heights, and speeds in m/s
inline constexpr double kRadPerLatitudeCount = std::numbers::pi / 180 * 1e-7;

// Full deflection of a stick. Attitude: 1000 / K_stick counts to a degree, K_stick 25.
inline constexpr double kFullTilt_rad = kStickCounts * 25e-3 * std::numbers::pi / 180;  // 51.2 deg
// The same formula with K_stick_yaw 120: 245.6 deg/s. AscTec's own letter says 254.760 deg/s = 4.43 rad/s,
// which are two other numbers; the formula is taken since it holds for the attitude.
inline constexpr double kFullYawRate_rad_s = kStickCounts * 120e-3 * std::numbers::pi / 180;
// In the GPS mode (kCtrlGps) pitch and roll ask for a velocity. "Approximately", of the internal bus, and
// unconfirmed on the serial port.
inline constexpr double kFullGpsSpeed_m_s = 3.0;

// The nearest count, within the deflection; no number is neutral.
inline std::int16_t StickCounts(double value, double full) {
  const double counts = std::round(value / full * kStickCounts);
  if (std::isnan(counts)) return 0;
  return static_cast<std::int16_t>(std::clamp<double>(counts, -kStickCounts, kStickCounts));
}
inline double FromStickCounts(std::int16_t counts, double full) { return full * counts / kStickCounts; }

// Thrust 0..1; no number is none.
inline std::int16_t ThrustCounts(double thrust) {
  const double counts = std::round(thrust * kThrustCounts);
  if (std::isnan(counts)) return 0;
  return static_cast<std::int16_t>(std::clamp<double>(counts, 0, kThrustCounts));
}
inline double FromThrustCounts(std::int16_t counts) { return static_cast<double>(counts) / kThrustCounts; }

// In the height and GPS modes thrust asks for a climb rate, 2047 for none. No source tells the rate of full
// deflection: it is the caller's.
inline std::int16_t ClimbCounts(double climb_m_s, double full_m_s) {
  return static_cast<std::int16_t>(kStickCounts + StickCounts(climb_m_s, full_m_s));
}

// How long bytes take on the line: 8 bits, a start and a stop.
inline constexpr double LineTime_s(std::size_t bytes, double baud = 57600) {
  return 10 * static_cast<double>(bytes) / baud;
}

}  // namespace kestrel::control::wire
