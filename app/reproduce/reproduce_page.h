// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/reproduce/thesis_items.h"

namespace kestrel::app {

// What became of a flight.
struct Reproduced {
  std::map<std::string, double> metrics;
  std::string outcome;
  std::string error;  // why it broke off
  std::filesystem::path folder;
};

// What stands on a card beside its flights' metrics.
struct Shown {
  std::string label;
  std::filesystem::path picture;  // a PNG or JPEG
  bool wide = false;              // across the whole card
};

struct ReproducedItem {
  const ThesisItem* item = nullptr;
  std::vector<Shown> pictures;
  std::vector<std::string> missing;  // pictures that could not be made, and why
};

// One page without any file beside it: each item with what the thesis says, the numbers beside each other, the
// pictures, and the commands that make them. flown: by the names of the flights.
std::string ReproducePage(const Thesis& thesis, const std::vector<ReproducedItem>& items,
                          const std::map<std::string, Reproduced>& flown, std::uint64_t seed);

}  // namespace kestrel::app
