// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>

#include "base/yaml/yaml_fields.h"

namespace kestrel::campaign {
namespace {

constexpr int kMaxShards = 100000;

// Both numbers of "I<between>N".
std::optional<Shard> Numbers(std::string_view text, std::string_view between) {
  const std::size_t at = text.find(between);
  if (at == std::string_view::npos) return std::nullopt;
  Shard shard;
  const auto number = [](std::string_view s, int& value) {
    const auto end = std::from_chars(s.data(), s.data() + s.size(), value);
    return end.ec == std::errc{} && end.ptr == s.data() + s.size();
  };
  if (!number(text.substr(0, at), shard.number) || !number(text.substr(at + between.size()), shard.of))
    return std::nullopt;
  if (shard.of < 1 || shard.of > kMaxShards || shard.number < 1 || shard.number > shard.of)
    return std::nullopt;
  return shard;
}

// To the last bit, but for the sign of zero, which SQLite does not keep.
bool Same(double a, double b) { return a == b || (a != a && b != b); }

}  // namespace

Shard ShardOf(const std::string& text) {
  const auto shard = Numbers(text, "/");
  if (!shard)
    throw InputError("--shard", fmt::format("'{}' is no part of a table", text),
                     fmt::format("valid: I/N with I from 1 to N, and N to {}, such as 3/8", kMaxShards));
  return *shard;
}

std::string FileNameOf(const Shard& shard) {
  return fmt::format("results-{}-of-{}.sqlite", shard.number, shard.of);
}

std::optional<Shard> ShardOfFile(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  constexpr std::string_view begin = "results-", end = ".sqlite";
  if (!name.starts_with(begin) || !name.ends_with(end)) return std::nullopt;
  return Numbers(std::string_view(name).substr(begin.size(), name.size() - begin.size() - end.size()),
                 "-of-");
}

std::vector<std::filesystem::path> ShardFiles(const std::filesystem::path& folder) {
  std::vector<std::pair<std::pair<int, int>, std::filesystem::path>> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none))
    if (const auto shard = ShardOfFile(entry.path()))
      files.push_back({{shard->of, shard->number}, entry.path()});
  std::sort(files.begin(), files.end());
  std::vector<std::filesystem::path> names;
  for (auto& [number, file] : files) names.push_back(std::move(file));
  return names;
}

std::string DifferenceOf(const RunResult& a, const RunResult& b) {
  if (a.status != b.status) return fmt::format("{} and {}", NameOf(a.status), NameOf(b.status));
  if (a.outcome != b.outcome) return fmt::format("'{}' and '{}'", a.outcome, b.outcome);
  if (a.state_hash != b.state_hash) return fmt::format("state hash {} and {}", a.state_hash, b.state_hash);
  if (a.image_hash != b.image_hash) return fmt::format("image hash {} and {}", a.image_hash, b.image_hash);
  for (const auto& [name, value] : a.metrics) {
    const auto other = b.metrics.find(name);
    if (other == b.metrics.end()) return fmt::format("{} is of one alone", name);
    if (!Same(value, other->second)) return fmt::format("{} {:.17g} and {:.17g}", name, value, other->second);
  }
  for (const auto& [name, value] : b.metrics)
    if (!a.metrics.contains(name)) return fmt::format("{} is of one alone", name);
  return {};
}

Merged Merge(const std::filesystem::path& into, CampaignIdentity identity,
             const std::vector<std::filesystem::path>& parts) {
  Mistakes mistakes;
  std::map<std::int64_t, std::pair<RunResult, std::string>> rows;  // and the file that it is of
  const auto add = [&](const std::filesystem::path& file, const ResultStore& store) {
    for (RunResult& result : store.Results()) {
      const std::int64_t row = result.row;
      const auto [there, is_new] = rows.try_emplace(row, result, file.string());
      if (is_new) continue;
      const std::string difference = DifferenceOf(there->second.first, result);
      if (!difference.empty())
        mistakes.Add(file.string(), "",
                     fmt::format("row {} came to something else than in {}: {}", row, there->second.second,
                                 difference),
                     "valid: one of the two files");
    }
  };
  Merged merged;
  std::optional<sim::Machine> machine;  // of the first part
  for (const auto& file : parts) {
    try {
      const ResultStore part = ResultStore::Read(file);
      if (!machine) identity.machine = *(machine = part.identity().machine);
      const auto differences = Differences(part.identity(), identity);
      for (const std::string& each : differences)
        mistakes.Add(file.string(), "", each,
                     "valid: parts of this campaign, flown by this version on machines that are alike");
      if (differences.empty()) add(file, part);
    } catch (const InputError& e) {
      mistakes.Add(e);
    }
  }
  mistakes.ThrowIfAny();
  ResultStore store = ResultStore::Open(into, identity);
  const std::set<std::int64_t> there = store.Rows();
  add(into, store);
  mistakes.ThrowIfAny();
  std::vector<RunResult> missing;
  for (auto& [row, result] : rows)
    if (!there.contains(row)) missing.push_back(std::move(result.first));
  store.Put(missing);
  merged.added = static_cast<std::int64_t>(missing.size());
  merged.there = static_cast<std::int64_t>(there.size());
  for (std::int64_t row = 0; row < static_cast<std::int64_t>(identity.table.rows.size()); ++row)
    if (!rows.contains(row)) merged.missing.push_back(row);
  return merged;
}

}  // namespace kestrel::campaign
