// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/law/fuzzy/fuzzy_controller.h"
#include "control/law/fuzzy/fuzzy_inference.h"

namespace kestrel::control {

// The sets and rules of a descent over a landmark, by "error" and "rate" to "descent". They are ours: thesis
// 5.3.1 says that a fuzzy controller controls the height, and prints none of it.
FuzzyController HeightController();

// Height by a fuzzy controller, thesis 5.3.1: from how far the aircraft is above where it is to be and how
// fast it sinks to how fast it is to sink. What the controller reads and says are shares of three scales,
// which stand outside of it, so that a tuning can turn them and leave its sets and rules.
struct FuzzyHeight {
  double error_scale_m = 5;
  double rate_scale_m_s = 1;
  double descent_scale_m_s = 0.8;
  FuzzyController controller = HeightController();
};

inline void Fields(FieldVisitor& v, FuzzyHeight& p) {
  v({"error_scale_m", "height error that is an error of 1 to the controller"}, p.error_scale_m, 0.1, 100.0);
  v({"rate_scale_m_s", "sink rate that is a rate of 1 to the controller"}, p.rate_scale_m_s, 0.05, 20.0);
  v({"descent_scale_m_s", "vertical velocity downwards that is a descent of 1 of the controller"},
    p.descent_scale_m_s, 0.05, 10.0);
  v({"controller", "fuzzy sets and rules, with the inputs error and rate and the output descent"},
    p.controller);
}

// Whatever is wrong with the controller, and variables that are not the three.
void CheckHeight(const FuzzyHeight& height, const std::string& key, const Place& where, Mistakes& mistakes);

// The velocity to command, m/s, downwards. error_m: height above where the aircraft is to be; sink_m_s: its
// velocity downwards. inference: of the controller. None: no rule fires, as by numbers that are not finite.
std::optional<double> FuzzyDescent(const FuzzyHeight& height, const FuzzyInference& inference, double error_m,
                                   double sink_m_s);

}  // namespace kestrel::control
