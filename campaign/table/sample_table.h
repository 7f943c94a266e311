// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kestrel::campaign {

// What varies from run to run, fixed before the first one flies: a run's result depends on its row alone.
struct SampleTable {
  std::vector<std::string> keys;               // of the scenario, dotted; "seed" is always the first
  std::vector<std::vector<std::string>> rows;  // in each a value for each key, as --set takes it
};

// "key=value" of each key of a row.
std::vector<std::string> OverridesOf(const SampleTable& table, std::size_t row);

// 16 hexadecimal digits: two tables of the same content have the same.
std::string HashOf(const SampleTable& table);

}  // namespace kestrel::campaign
