// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace kestrel {

struct BenchArguments {
  std::string name;  // empty: all
  std::string seeds = "1..20";
  int jobs = 2;
  std::string json;
  std::string out = "results/runs/bench_horizon";  // folder of what horizon and contrast leave
};

// One line of the table.
struct Figure {
  std::string name;
  double value = 0;
  std::string unit;
  std::optional<double> target;  // none: shown for comparison
  bool at_least = false;
  std::string reference;  // the thesis's figure, or the peers'
  bool Met() const { return !target || (at_least ? value >= *target : value <= *target); }
};

std::vector<std::string> BenchNames();

// Measures, prints a table of figures beside their targets, and returns whether all of them were met. Throws
// InputError if the seeds are not A..B.
bool Bench(const BenchArguments& arguments);

}  // namespace kestrel
