// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "control/law/fuzzy/fuzzy_height.h"
#include "mission/touch_down/touch_down_records.h"

namespace kestrel::scenarios {

struct FuzzyDescentLaw {
  control::FuzzyHeight height;
  control::FuzzyInference inference;  // of its controller
};

// What the fuzzy law said of one frame, and the law.
struct DescentReport final : mission::TouchDownReport {
  DescentReport(std::shared_ptr<const FuzzyDescentLaw> of, double height, double sinking, double descent)
      : law(std::move(of)), height_m(height), sink_m_s(sinking), descent_m_s(descent) {}

  std::shared_ptr<const FuzzyDescentLaw> law;
  double height_m, sink_m_s;  // above the pad and downwards, by the estimate
  double descent_m_s;         // what was asked for, before its limits
};

}  // namespace kestrel::scenarios
