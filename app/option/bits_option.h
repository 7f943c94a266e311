// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "app/option/within.h"

namespace kestrel::app {

// --bits of a command that reads images: for PixelDepth.
inline void AddBitsOption(CLI::App& command, std::optional<int>& bits) {
  command
      .add_option("--bits", bits,
                  "How many bits the camera has, of images in 16 bits that do not say it (default: as few as "
                  "hold their largest value)")
      ->check(WholeNumber(8, 16));
}

}  // namespace kestrel::app
