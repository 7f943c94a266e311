// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "mission/decision.h"

namespace kestrel::python {

// A decision with words of its own, which outlive the mission.
struct OwnedDecision {
  explicit OwnedDecision(const mission::Decision& of)
      : decision(of), phase(of.phase), target(of.target), outcome(of.outcome) {
    decision.phase = decision.target = decision.outcome = {};
    decision.report.reset();
  }
  mission::Decision decision;
  std::string phase, target, outcome;
};

}  // namespace kestrel::python
