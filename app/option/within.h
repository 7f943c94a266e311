// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kestrel::app {

// Refuses an option that is no number from the least to the most. CLI::Range lets a NaN pass.
CLI::Validator Within(double least, double most);

// Refuses an option that is no whole number from the least to the most.
CLI::Validator WholeNumber(int least, int most);

// An option that is given and empty would be as if it were not.
inline std::string NotEmpty(const std::string& text) { return text.empty() ? "it is empty" : ""; }

}  // namespace kestrel::app
