// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace kestrel {

// What the command lines of campaigns and of tunings have in common.

// Refuses an option that is no whole number from low to high.
CLI::Validator WholeNumber(int low, int high);

// Until another handler is set: an interrupt, or the request to terminate, ends the program at once, with a
// word and the status of what broke off.
void EndOnInterrupt();

}  // namespace kestrel
