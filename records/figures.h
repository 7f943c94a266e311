// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace kestrel::records {

// One line of a table of figures.
struct Figure {
  std::string name;
  double value = 0;
  std::string unit;
  std::optional<double> target;  // none: shown for comparison
  bool at_least = false;
  std::string reference;  // the thesis's figure, or the peers'
  bool Met() const { return !target || (at_least ? value >= *target : value <= *target); }
};

void PrintFigures(const std::vector<Figure>& table);
// Throws std::runtime_error with the file and the reason.
void WriteFigures(const std::string& json_file, const std::vector<Figure>& table);
bool AllMet(const std::vector<Figure>& table);

}  // namespace kestrel::records
