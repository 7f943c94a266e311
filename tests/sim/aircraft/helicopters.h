// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/aircraft/helicopter.h"

namespace kestrel::sim {

// The MIT X-Cell .60 of V. Gavrilets, B. Mettler, E. Feron, "Dynamic model for a miniature aerobatic
// helicopter", 2001, table 1, as far as it decides how the rotor moves the fuselage.
inline HelicopterParameters XCell() {
  HelicopterParameters p;
  p.mass_kg = 8.2;
  p.inertia_kg_m2 = {0.18, 0.34, 0.28};
  p.rotor_height_m = 0.235;
  p.rotor = {0.775, 2, 0.058, 5.5, 0.024, 0.0055};
  p.flapping.blade_inertia_kg_m2 = 0.038;
  p.flapping.hub_stiffness_n_m = 54;
  p.flapping.bar_lock_number = 0.8;
  p.drive.speed_rad_s = 167;
  p.drive.power_w = 2000;
  p.drive.inertia_kg_m2 = 2.5 * 0.038;
  p.tail_gear = 4.66;
  p.tail_arm_m = 0.91;
  return p;
}

}  // namespace kestrel::sim
