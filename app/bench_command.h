// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kestrel::app {

struct BenchArguments {
  std::string name;  // empty: all
  std::string seeds = "1..20";
  int jobs = 2;
  std::string json;
  std::string out = "results/runs/bench_horizon";  // folder of what horizon and contrast leave
};

std::vector<std::string> BenchNames();

// Measures, prints a table of figures beside their targets, and returns whether all of them were met. Throws
// InputError if the seeds are not A..B.
bool Bench(const BenchArguments& arguments);

}  // namespace kestrel::app
