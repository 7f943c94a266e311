// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"

namespace kestrel::campaign {

// A part of a table: of its rows those r with r % of == number - 1.
struct Shard {
  int number = 1, of = 1;  // number from 1
  bool Has(std::int64_t row) const { return row % of == number - 1; }
};

// "3/8". Throws InputError.
Shard ShardOf(const std::string& text);

// "results-3-of-8.sqlite"
std::string FileNameOf(const Shard& shard);
// Of such a name; none: it is another.
std::optional<Shard> ShardOfFile(const std::filesystem::path& file);

// The result files of parts in a folder, in the order of their numbers.
std::vector<std::filesystem::path> ShardFiles(const std::filesystem::path& folder);

// What a table has after its parts were joined.
struct Merged {
  std::int64_t added = 0, there = 0;  // rows that came in, and that were in it already
  std::vector<std::int64_t> missing;  // rows that no part has
};

// Joins result files into one, which may have some of the rows already. Where it is done does not matter, but
// all were flown on machines that are alike. Throws InputError: a part is of another machine, version, plan
// or table; or two have the same row with different results, each named. Nothing is written then.
Merged Merge(const std::filesystem::path& into, CampaignIdentity identity,
             const std::vector<std::filesystem::path>& parts);

// Whether two flights of a row came to the same, to the last bit: their status, outcome, metrics and hashes.
// Otherwise what differs, in words.
std::string DifferenceOf(const RunResult& a, const RunResult& b);

}  // namespace kestrel::campaign
