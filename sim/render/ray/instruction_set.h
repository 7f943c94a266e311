// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Several libraries, and the ray renderer, are compiled for several instruction sets and take the best when
// they run. Their results differ in the last bits, and a flight with them: machines that are to agree take
// the same.
namespace kestrel::sim {

// The names of those that can be chosen, the least first. Empty where the processor is no x86-64.
std::span<const std::string_view> InstructionSets();

// The one that the ray renderer and Embree go by: one of these names, or what Highway calls it elsewhere.
std::string InstructionSet();

// Has the ray renderer and Embree go by this one, from the next picture and the next world on. Throws
// InputError: there is no such name, or this machine has not got it. chosen_by: the option or variable that named it.
void UseInstructionSet(const std::string& name, const char* chosen_by = "--isa");

// What the environment of a process must hold from its start for the C library and OpenCV to go by one too:
// variables with their values, empty: none.
std::vector<std::pair<std::string, std::string>> EnvironmentOf(const std::string& instruction_set);

}  // namespace kestrel::sim
