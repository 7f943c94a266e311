// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace kestrel::app {

// Refuses an option that is no number from the least to the most. CLI::Range lets a NaN pass.
CLI::Validator Within(double least, double most);

}  // namespace kestrel::app
