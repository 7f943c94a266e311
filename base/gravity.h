// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// The standard acceleration of free fall, in m/s^2 (3rd CGPM, 1901). Sensors that give accelerations in units
// of it mean this value.
inline constexpr double kGravity_m_s2 = 9.80665;

}  // namespace kestrel
