// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timing_machine.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "campaign/execution/run_campaign.h"
#include "sim/machine.h"

namespace kestrel::bench {

std::string ProcessorIn(const std::string& cpuinfo) {
  // Arm's has no name of the model, but numbers.
  for (const std::string key : {"model name", "CPU part"}) {
    std::istringstream lines(cpuinfo);
    for (std::string line; std::getline(lines, line);) {
      const std::size_t colon = line.find(':');
      if (!line.starts_with(key) || colon == std::string::npos) continue;
      const std::size_t from = line.find_first_not_of(" \t", colon + 1);
      if (from != std::string::npos) return line.substr(from);
    }
  }
  return "unknown";
}

TimingMachine ThisTimingMachine() {
  TimingMachine machine = sim::ThisMachine();
  std::ifstream file("/proc/cpuinfo");
  std::ostringstream text;
  text << file.rdbuf();
  machine["processor"] = ProcessorIn(text.str());
  machine["cores"] = fmt::format("{}", campaign::Cores());
  return machine;
}

std::vector<std::string> WhyNotComparable(const TimingMachine& there, const TimingMachine& here) {
  std::vector<std::string> why;
  for (const char* key : {"processor", "cores", "instruction_set"}) {
    const auto value = [&](const TimingMachine& machine) {
      const auto at = machine.find(key);
      return at == machine.end() ? "not told" : at->second;
    };
    if (value(there) != value(here))
      why.push_back(fmt::format("{}: {} there, {} here", key, value(there), value(here)));
  }
  return why;
}

}  // namespace kestrel::bench
