// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/diagnostics.h"

namespace kestrel::sim {

// What is known of a multirotor before it is measured, by options of their names.
struct VehicleDraft {
  std::string name;
  double mass_kg = 1.5;
  double arm_m = 0.25;             // from the centre to each shaft
  std::string layout = "x";        // plus, x, h (two rails)
  int rotors = 4;                  // 4, 6 or 8
  int cells = 4;                   // of lithium in series
  double thrust_to_weight = 2;     // where kv_rpm_v does not tell
  std::optional<double> kv_rpm_v;  // of the motors
  std::optional<double>
      propeller_m;  // diameter; none: the largest that leaves a gap of a tenth between rotors
};

// A vehicle file that flies, with what was assumed written in it. What cannot fly is a mistake: too little
// thrust, rotors that overlap, tips that are too fast. Then the text is empty.
std::string VehicleText(const VehicleDraft& draft, Mistakes& mistakes);

}  // namespace kestrel::sim
