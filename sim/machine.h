// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>

namespace kestrel::sim {

// What decides the last bits of a flight beside the program's version, its files and its seed: libraries, and
// what they choose by the processor when they run. Flights on two machines that are alike in all of it are
// the same, bit for bit, as long as the ray renderer draws them. By name:
//   instruction_set  that the ray renderer and Embree go by
//   reciprocals      hash of the processor's approximate reciprocals, which Embree begins with and vendors
//                    make each their own way
//   c_library        with its version
//   mathematics      the variant of its sine, exponential, ...: fma, fma4, sse2
//   opencv           version, and the processor's features beyond its baseline that it uses
//   lapack           the library that solves larger systems for OpenCV
//   embree, mujoco   versions
//   build            compiler, and versions of what is compiled in
using Machine = std::map<std::string, std::string>;

// This one, by the instruction set that is in use now.
Machine ThisMachine();

// In what two differ: the name, and what either has.
std::map<std::string, std::pair<std::string, std::string>> MachineDifferences(const Machine& a,
                                                                              const Machine& b);

}  // namespace kestrel::sim
