// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "control/law/fuzzy/fuzzy_set.h"

namespace kestrel::control {

// What a rule makes of the set of its conclusion: a trapezoid of that height.
struct ImpliedSet {
  Eigen::Vector4d corners;
  double height = 0;  // 0 to 1: how far the rule fires
};

ImpliedSet CutOff(const FuzzySet& set, double height);  // the minimum of both
ImpliedSet Scaled(const FuzzySet& set, double height);  // their product

enum class Aggregation { kMax, kSum };

// The centroid of sets joined, over [low, high], in closed form: the join of trapezoids is straight between
// their corners and crossings. None: there is no area.
std::optional<double> Centroid(const std::vector<ImpliedSet>& sets, Aggregation aggregation, double low,
                               double high);

}  // namespace kestrel::control
