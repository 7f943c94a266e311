// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace kestrel::app {

// Refuses an option that is none of these words, with the nearest of them.
CLI::Validator OneOf(std::vector<std::string> words);

}  // namespace kestrel::app
