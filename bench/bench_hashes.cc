// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_hashes.h"

#include <fmt/format.h>

#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/process/in_parallel.h"
#include "flight/simulated/runner.h"
#include "sim/machine.h"

namespace kestrel::bench {
namespace {

constexpr const char* kHeader = "scenario,seed,state_hash,image_hash";

using Key = std::pair<std::string, std::string>;  // scenario, seed
using Hashes = std::map<Key, std::string>;        // "state,image"

std::string MachineLines() {
  std::string lines;
  for (const auto& [name, value] : sim::ThisMachine()) lines += fmt::format("# {}: {}\n", name, value);
  return lines;
}

struct Kept {
  std::string machine;
  Hashes hashes;
};

Kept ReadKept(const std::filesystem::path& file) {
  Kept kept;
  std::istringstream text(ReadFile(file));
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with('#')) {
      kept.machine += line + '\n';
      continue;
    }
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    if (line == kHeader || second == std::string::npos) continue;
    kept.hashes[{line.substr(0, first), line.substr(first + 1, second - first - 1)}] =
        line.substr(second + 1);
  }
  return kept;
}

}  // namespace

void BenchHashes(flight::SeedRange seeds, int jobs, const std::filesystem::path& kept_file,
                 std::vector<records::Figure>& table) {
  std::vector<Key> flights;
  for (const std::string& scenario : ScenarioNames())
    for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed)
      flights.emplace_back(scenario, fmt::format("{}", seed));
  std::vector<std::string> lines(flights.size());
  InParallel(flights.size(), jobs, "hashes", "flights", [&](std::size_t i) {
    const auto& [scenario, seed] = flights[i];
    const records::Summary summary =
        flight::RunFlight(flight::LoadScenario(scenario, {"seed=" + seed}), {}).summary;
    if (!summary.complete)
      throw std::runtime_error(fmt::format("{}, seed {}: {}", scenario, seed, summary.error));
    lines[i] = fmt::format("{:016x},{:016x}", summary.state_hash, summary.image_hash);
  });

  const Kept kept = ReadKept(kept_file);
  const std::string machine = MachineLines();
  std::string text = machine + kHeader + '\n';
  int differing = 0;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const auto& [scenario, seed] = flights[i];
    const auto before = kept.hashes.find(flights[i]);
    const bool differs = before != kept.hashes.end() && before->second != lines[i];
    differing += differs;
    fmt::print("{:<18} {:>3}  {}{}\n", scenario, seed, lines[i],
               differs                       ? "  was " + before->second
               : before == kept.hashes.end() ? "  new"
                                             : "");
    text += fmt::format("{},{},{}\n", scenario, seed, lines[i]);
  }
  if (kept.hashes.empty()) {
    WriteFile(kept_file, text);
    fmt::print("kept in {}\n", kept_file.string());
    return;  // there was nothing to compare them with
  }
  if (kept.machine == machine) {
    table.push_back({"flights whose hashes changed", static_cast<double>(differing), "", 0, false, ""});
    return;
  }
  fmt::print("{} was made by another machine: hashes that differ from it tell of no change\n",
             kept_file.string());
  table.push_back({"flights whose hashes are not the other machine's",
                   static_cast<double>(differing),
                   "",
                   {},
                   false,
                   ""});
}

}  // namespace kestrel::bench
