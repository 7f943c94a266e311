// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/horizon/bench_photographs.h"
#include "flight/simulated/seeds.h"
#include "records/figures.h"

namespace kestrel::app {

struct BenchArguments;

// What a bench measures by.
struct BenchInput {
  const BenchArguments& arguments;
  flight::SeedRange seeds;
  std::filesystem::path folder;  // for the files that it leaves
  std::vector<bench::Photograph> photographs;
  int jobs() const;
};

// A bench of `kestrel bench`.
struct Bench {
  // Those that run when none is named; those that run by their name alone, because they take long, real time, a machine
  // at rest or photographs; and those of them that print tables of their own.
  enum class Kind { kGeneral, kByName, kOfOwnTables };
  std::string name;
  Kind kind = Kind::kGeneral;
  std::vector<std::string> options;  // that it takes, beside --json
  void (*run)(const BenchInput& input, std::vector<records::Figure>& table) = nullptr;

  bool Takes(const std::string& option) const;
};

const std::vector<Bench>& Benches();  // in the order in which they run

}  // namespace kestrel::app
