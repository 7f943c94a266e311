// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "mission/decision.h"

namespace kestrel::scenarios {

// The intruder that matters most, as the flight code has it.
struct Encounter {
  double azimuth = 0;            // in the heading frame, right positive, rad
  std::optional<double> wanted;  // the bearing at which it is held, rad; none: nothing need be done
  std::optional<double> range_m{}, miss_m{}, after_s{};  // miss: the closest distance if both go on, and when
};

struct AvoidReport final : mission::MissionReport {
  Encounter encounter;
};

// Null: no intruder is in sight.
inline const Encounter* EncounterOf(const mission::Decision& decision) {
  const auto* report = mission::ReportOf<AvoidReport>(decision);
  return report ? &report->encounter : nullptr;
}

}  // namespace kestrel::scenarios
