// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"

namespace kestrel::campaign {

// A table of so many rows, that varies the seed and one key.
inline SampleTable TableOf(int rows, const std::string& key = "wind.mean_m_s") {
  SampleTable table{{"seed", key}, {}};
  for (int row = 0; row < rows; ++row)
    table.rows.push_back({fmt::format("{}", row + 7), fmt::format("{:.17g}", row / 3.0)});
  return table;
}

inline CampaignIdentity IdentityOf(const SampleTable& table) {
  return {"gusts", "mission: hover\nduration_s: 1\n", "scenario: hover\nruns: 4\n", "0.1.0 abc", table};
}

inline RunResult ResultOf(std::int64_t row) {
  RunResult result;
  result.row = row;
  result.status = row % 3 == 2 ? RunStatus::kFailed : RunStatus::kPassed;
  result.outcome = "completed";
  result.metrics = {{"error_m", std::sin(static_cast<double>(row))}, {"settle_s", 1.0 / 3}};
  result.state_hash = fmt::format("{:016x}", row), result.image_hash = fmt::format("{:016x}", row * 3);
  return result;
}

}  // namespace kestrel::campaign
