// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/sample_table.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace kestrel::campaign {

std::vector<std::string> OverridesOf(const SampleTable& table, std::size_t row) {
  std::vector<std::string> overrides;
  for (std::size_t k = 0; k < table.keys.size(); ++k)
    overrides.push_back(fmt::format("{}={}", table.keys[k], table.rows[row][k]));
  return overrides;
}

std::string HashOf(const SampleTable& table) {
  // Each text with its length, so that no two tables run together into the same bytes.
  std::string all = fmt::format("{} keys\n", table.keys.size());
  const auto add = [&](const std::string& text) { all += fmt::format("{}:{}\n", text.size(), text); };
  for (const std::string& key : table.keys) add(key);
  for (const auto& row : table.rows)
    for (const std::string& value : row) add(value);
  return fmt::format("{:016x}", XXH3_64bits(all.data(), all.size()));
}

}  // namespace kestrel::campaign
