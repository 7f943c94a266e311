// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/stamped_table.h"

#include <fmt/format.h>

#include <sstream>

#include "base/user_file.h"

namespace kestrel::vision {
namespace {

constexpr int kMaxTold = 20;

std::vector<std::string> CellsOf(std::string line, char between) {
  if (between == ' ')
    for (char& c : line)
      if (c == '\t') c = ' ';
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, between);) {
    const std::size_t from = cell.find_first_not_of(" \t"), to = cell.find_last_not_of(" \t");
    if (from == std::string::npos && between == ' ') continue;
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
  }
  return cells;
}

}  // namespace

std::string StampOrder::Next(std::int64_t stamp_ns, const std::string& of) {
  std::string wrong;
  if (!last.empty() && stamp_ns == last_ns)
    wrong = fmt::format("the stamp {} comes twice", of);
  else if (!last.empty() && stamp_ns < last_ns)
    wrong = fmt::format("the stamp {} goes back: {} came before it", of, last);
  else
    last_ns = stamp_ns, last = of;
  return wrong;
}

void ReadTable(const std::filesystem::path& file, const TableForm& form, Mistakes& mistakes,
               const TableRow& row) {
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) return mistakes.Add(file.string(), "", content.error);
  std::istringstream in(content.bytes);
  StampOrder order;
  std::string line;
  int wrong = 0;
  for (int number = 1; std::getline(in, line); ++number) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> cells = CellsOf(line, form.between);
    const bool shaped = cells.size() >= form.least_cells && cells.size() <= form.most_cells;
    const auto stamp = shaped ? form.stamp(cells[0]) : std::nullopt;
    std::string what, remedy = fmt::format("valid: {}, in the order of time", form.row);
    if (!shaped) {
      what = fmt::format("'{:.80}' has {} cell{}", line, cells.size(), cells.size() == 1 ? "" : "s");
    } else if (!stamp) {
      what = fmt::format("'{:.80}' is no stamp", cells[0]);
    } else if (what = order.Next(*stamp, cells[0]); what.empty()) {
      what = row(*stamp, cells);
      if (form.rest) remedy = fmt::format("valid: {}", form.rest);
    }
    if (!what.empty() && ++wrong <= kMaxTold) mistakes.Add({file.string(), number}, "", what, remedy);
  }
  if (wrong > kMaxTold)
    mistakes.Add(file.string(), "", fmt::format("and {} more mistakes in its rows", wrong - kMaxTold));
}

}  // namespace kestrel::vision
