// SPDX-License-Identifier: Apache-2.0
#include "records/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/file/files.h"

namespace kestrel::records {

void PrintFigures(const std::vector<Figure>& table) {
  if (table.empty()) return;
  fmt::print("| {:<60} | {:>9} | {:>9} | {:>9} | {:<11} |    |\n", "figure", "reference", "target",
             "measured", "unit");
  fmt::print("|{:-<62}|{:->10}:|{:->10}:|{:->10}:|{:-<13}|----|\n", "", "", "", "", "");
  for (const Figure& f : table) {
    const std::string target = f.target ? fmt::format("{} {:.4g}", f.at_least ? ">=" : "<=", *f.target) : "";
    fmt::print("| {:<60} | {:>9} | {:>9} | {:>9.3g} | {:<11} | {} |\n", f.name, f.reference, target, f.value,
               f.unit, f.Met() ? "  " : "no");
  }
}

void WriteFigures(const std::string& json_file, const std::vector<Figure>& table) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Figure& f : table) {
    all.push_back({{"name", f.name},
                   {"value", f.value},
                   {"unit", f.unit},
                   {"target", f.target ? nlohmann::ordered_json(*f.target) : nlohmann::ordered_json()},
                   {"reference", f.reference},
                   {"met", f.Met()}});
  }
  WriteFile(json_file, all.dump(2) + "\n");
}

bool AllMet(const std::vector<Figure>& table) {
  return std::all_of(table.begin(), table.end(), [](const Figure& f) { return f.Met(); });
}

}  // namespace kestrel::records
