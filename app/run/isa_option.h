// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace kestrel::app {

// `--isa`: one instruction set for all that a flight is computed by, so that machines with better ones agree
// with those without. The C library and OpenCV choose as a process begins: it is begun again, with an
// environment that says so, which the programs that it starts inherit.

// To a command, and to those under it.
void AddIsaOption(CLI::App* command, std::string& isa);

// Goes by this set, or by the one that the environment names where none is given; none: nothing is done. Does
// not return where the program is begun again, by the same arguments. Throws InputError: there is no such set
// here; std::runtime_error: it cannot be begun again.
void GoBy(const std::string& isa, char** arguments);

// For a program that was started by one that did so.
void GoByTheEnvironment();

// The one that this program was told to go by, as a command line that is to do the same must say; empty:
// none.
std::string ChosenInstructionSet();

}  // namespace kestrel::app
