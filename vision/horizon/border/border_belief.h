// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "vision/horizon/border/border_look.h"
#include "vision/horizon/border/border_search.h"

namespace kestrel::vision {

// What tells the border between sky and ground from the edge of a cloud, a field, a shore or a table: numbers of
// about unit size, the first of them 1.
inline constexpr int kBorderFeatures = 16;
std::array<double, kBorderFeatures> BorderFeatures(const BorderLook& look, const BorderSides& sides);

std::array<double, kBorderFeatures> BorderWeights();

// A line of less belief, or of less contrast above to below (grey levels of all channels), is no answer.
inline constexpr double kLeastBelief = 1.6, kLeastContrast = 12;

// Log of the odds that a line is the horizon to a degree and a half: a logistic model.
double BorderBelief(const BorderLook& look, const BorderSides& sides);

}  // namespace kestrel::vision
