// SPDX-License-Identifier: Apache-2.0
#include "base/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

namespace kestrel {

std::optional<std::string> NearestName(std::string_view name, const std::vector<std::string>& valid) {
  const auto distance = [](std::string_view a, std::string_view b) {  // Levenshtein
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0u);
    for (std::size_t i = 0; i < a.size(); ++i) {
      std::size_t diagonal = row[0]++;
      for (std::size_t j = 0; j < b.size(); ++j) {
        const std::size_t changed = diagonal + (a[i] != b[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({changed, row[j] + 1, diagonal + 1});
      }
    }
    return row.back();
  };
  std::optional<std::string> nearest;
  // Beyond a third of the letters it would be a guess.
  std::size_t least = (name.size() < 4 ? 1 : std::max<std::size_t>(2, name.size() / 3)) + 1;
  for (const std::string& each : valid) {
    if (name.size() >= each.size() + least || each.size() >= name.size() + least) continue;
    if (const std::size_t d = distance(name, each); d < least) least = d, nearest = each;
  }
  return nearest;
}

std::string RemedyForName(std::string_view name, const std::vector<std::string>& valid) {
  const auto near = NearestName(name, valid);
  return near ? fmt::format("did you mean '{}'?", *near) : fmt::format("valid: {}", fmt::join(valid, ", "));
}

}  // namespace kestrel
