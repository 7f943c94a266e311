// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace kestrel::flight {

struct SeedRange {
  std::uint64_t first = 1, last = 20;
};

// "A..B". Throws InputError.
SeedRange ParseSeeds(const std::string& text);

}  // namespace kestrel::flight
