// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel campaign compare A B`: two campaigns on the same rows.
struct CompareArguments {
  std::string a, b;  // each a result file, a folder that holds results.sqlite, or a campaign's name
  std::vector<std::string> metrics;
  std::string json;
  std::uint64_t seed = 1;
};

// Under a command, "campaign" or the program's own.
CLI::App* AddCompareCommand(CLI::App& parent, CompareArguments& arguments);

// Prints what differs and whether B is better; false: it is worse. Throws InputError.
bool CompareCommand(const CompareArguments& arguments);

}  // namespace kestrel::app
