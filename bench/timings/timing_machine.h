// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

namespace kestrel::bench {

// What times depend on beside the program: processor, cores (that this process may use), instruction_set; and what
// sim::ThisMachine() has of libraries and compilers, which may differ between builds that are compared.
using TimingMachine = std::map<std::string, std::string>;
TimingMachine ThisTimingMachine();

// Why times of the two cannot be compared, a phrase each: "processor: A there, B here". None: they can.
std::vector<std::string> WhyNotComparable(const TimingMachine& there, const TimingMachine& here);

// The processor's name in a text as that of /proc/cpuinfo; "unknown".
std::string ProcessorIn(const std::string& cpuinfo);

}  // namespace kestrel::bench
