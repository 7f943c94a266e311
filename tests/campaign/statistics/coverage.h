// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "base/random.h"
#include "base/share_interval.h"

namespace kestrel::campaign {

// The share of simulated samples of which the interval holds the truth.
inline double Coverage(int simulations, double truth,
                       const std::function<Interval(RandomStream&)>& simulate) {
  RandomStream random(20, "coverage");
  int held = 0;
  for (int i = 0; i < simulations; ++i) held += simulate(random).Holds(truth);
  return static_cast<double>(held) / simulations;
}

// By how much the share of so many simulations may miss its probability by chance: four deviations.
inline double Chance(int simulations, double level = 0.95) {
  return 4 * std::sqrt(level * (1 - level) / simulations);
}

}  // namespace kestrel::campaign
