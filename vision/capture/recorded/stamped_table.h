// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"

namespace kestrel::vision {

// Stamps must go up.
struct StampOrder {
  std::int64_t last_ns = 0;
  std::string last = {};  // what had it; empty: none has come
  // Empty: it is later than all before it; otherwise what is wrong.
  std::string Next(std::int64_t stamp_ns, const std::string& of);
};

// How a table of stamps is written.
struct TableForm {
  char between;  // cells; a space: one or more spaces and tabs
  std::size_t least_cells, most_cells;
  std::optional<std::int64_t> (*stamp)(std::string_view);  // of the first cell
  const char* row;                                         // what a row must be
  const char* rest = nullptr;  // the same of what a TableRow is to judge; null: `row`
};

// What is wrong with the rest of a row, whose cells these are; empty: nothing.
using TableRow = std::function<std::string(std::int64_t stamp_ns, const std::vector<std::string>& cells)>;

// Gives the rows of a file that are no comments ("#") in the order of their stamps. Each that is not as the form
// has it, whose stamp is not later than that before it, or with which `row` finds something wrong is a mistake:
// the first 20 by themselves, the others as a number.
void ReadTable(const std::filesystem::path& file, const TableForm& form, Mistakes& mistakes,
               const TableRow& row);

}  // namespace kestrel::vision
