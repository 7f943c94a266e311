// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "flight/simulated/runner.h"

namespace kestrel {

inline flight::FlightResult Flown(const std::string& scenario, std::uint64_t seed,
                                  std::vector<std::string> overrides = {}) {
  overrides.push_back("seed=" + std::to_string(seed));
  const flight::FlightResult result = flight::RunFlight(flight::LoadScenario(scenario, overrides), {});
  EXPECT_EQ(result.summary.error, "");
  EXPECT_FALSE(result.rows.empty());
  return result;
}

inline void ExpectCriteria(const flight::FlightResult& result) {
  EXPECT_FALSE(result.summary.criteria.empty());
  for (const records::Criterion& c : result.summary.criteria) {
    if (c.at_least) {
      EXPECT_GE(c.value, c.limit) << c.name << ", seed " << result.summary.seed;
    } else {
      EXPECT_LE(c.value, c.limit) << c.name << ", seed " << result.summary.seed;
    }
  }
}

}  // namespace kestrel
