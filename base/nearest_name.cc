// SPDX-License-Identifier: Apache-2.0
#include "base/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace kestrel {
namespace {

struct Distance {
  std::size_t whole, beginning;  // of the name to all of another, and to as much of it as is nearest
};

// Damerau and Levenshtein's: letters inserted, left out, changed, or two neighbours exchanged.
Distance DistanceOf(std::string_view name, std::string_view other) {
  std::vector<std::size_t> row(other.size() + 1), before, before_that;
  std::iota(row.begin(), row.end(), 0u);
  for (std::size_t i = 0; i < name.size(); ++i) {
    before_that = std::exchange(before, row);
    row[0] = i + 1;
    for (std::size_t j = 0; j < other.size(); ++j) {
      row[j + 1] = std::min({before[j] + (name[i] != other[j]), before[j + 1] + 1, row[j] + 1});
      if (i > 0 && j > 0 && name[i] == other[j - 1] && name[i - 1] == other[j])
        row[j + 1] = std::min(row[j + 1], before_that[j - 1] + 1);
    }
  }
  return {row.back(), *std::min_element(row.begin(), row.end())};
}

}  // namespace

std::optional<std::string> NearestName(std::string_view name, const std::vector<std::string>& valid) {
  // Beyond a third of the letters it would be a guess; of a name that was cut short, beyond one letter.
  const std::size_t max_whole = std::max<std::size_t>(1, name.size() / 3);
  const std::size_t max_beginning = name.size() < 6 ? 0 : 1;
  std::optional<std::string> nearest;
  std::pair<std::size_t, std::size_t> least(max_whole + 1, 0);
  for (const std::string& each : valid) {
    const Distance d = DistanceOf(name, each);
    const bool cut_short = name.size() >= 4 && d.beginning <= max_beginning;
    if (d.whole > max_whole && !cut_short) continue;
    const std::pair by(cut_short ? std::min(d.whole, d.beginning + 1) : d.whole, d.whole);
    if (nearest && by >= least) continue;
    least = by;
    nearest = each;
  }
  return nearest;
}

std::string RemedyForName(std::string_view name, const std::vector<std::string>& valid) {
  const auto near = NearestName(name, valid);
  return near ? fmt::format("did you mean '{}'?", *near) : fmt::format("valid: {}", fmt::join(valid, ", "));
}

}  // namespace kestrel
