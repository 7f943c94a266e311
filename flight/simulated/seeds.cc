// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/seeds.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <string_view>

#include "base/diagnostics.h"

namespace kestrel::flight {
namespace {

constexpr std::uint64_t kMaxSeeds = 1000;  // their flights are held in memory

}  // namespace

SeedRange ParseSeeds(const std::string& text) {
  const std::size_t dots = text.find("..");
  const auto number = [](std::string_view s, std::uint64_t& value) {
    const auto end = std::from_chars(s.data(), s.data() + s.size(), value);
    return end.ec == std::errc{} && end.ptr == s.data() + s.size();
  };
  SeedRange seeds;
  if (dots == std::string::npos || !number(std::string_view(text).substr(0, dots), seeds.first) ||
      !number(std::string_view(text).substr(dots + 2), seeds.last) || seeds.last < seeds.first) {
    throw InputError("--seeds", fmt::format("'{}' is not a range", text),
                     "valid: A..B with A <= B, such as 1..20");
  }
  if (seeds.last - seeds.first >= kMaxSeeds || seeds.last > std::numeric_limits<std::int64_t>::max()) {
    throw InputError("--seeds", fmt::format("'{}' is too much", text),
                     fmt::format("valid: at most {} seeds, below 2^63", kMaxSeeds));
  }
  return seeds;
}

}  // namespace kestrel::flight
