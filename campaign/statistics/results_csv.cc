// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/results_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

namespace kestrel::campaign {
namespace {

// A spreadsheet takes a cell that begins so for a formula, which may call programs; an apostrophe before it
// says that it is a text.
bool IsFormula(std::string_view text) {
  if (text.empty() || std::string_view("=+-@\t\r").find(text[0]) == std::string_view::npos) return false;
  double value = 0;
  const std::string_view number = text.substr(text[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  return error != std::errc() || end != number.data() + number.size();
}

void AddCell(std::string& line, const std::string& given) {
  const std::string text = IsFormula(given) ? '\'' + given : given;
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    line += text;
  } else {
    line += '"';
    for (const char c : text) line += c == '"' ? std::string("\"\"") : std::string(1, c);
    line += '"';
  }
  line += ',';
}

void EndLine(std::string& text) {
  text.back() = '\r';  // for the comma
  text += '\n';
}

}  // namespace

std::string ToCsv(const SampleTable& table, const std::vector<RunResult>& results) {
  std::set<std::string> metrics;
  std::vector<const RunResult*> in_order;
  for (const RunResult& result : results) {
    in_order.push_back(&result);
    for (const auto& [name, value] : result.metrics) metrics.insert(name);
  }
  std::sort(in_order.begin(), in_order.end(), [](const auto* a, const auto* b) { return a->row < b->row; });

  std::string text;
  AddCell(text, "row");
  for (const std::string& key : table.keys) AddCell(text, key);
  AddCell(text, "status"), AddCell(text, "outcome");
  for (const std::string& metric : metrics) AddCell(text, metric);
  AddCell(text, "state_hash"), AddCell(text, "image_hash");
  EndLine(text);
  for (const RunResult* run : in_order) {
    AddCell(text, fmt::format("{}", run->row));
    for (const std::string& value : table.rows.at(static_cast<std::size_t>(run->row))) AddCell(text, value);
    AddCell(text, std::string(NameOf(run->status))), AddCell(text, run->outcome);
    for (const std::string& metric : metrics) {
      const auto found = run->metrics.find(metric);
      const bool there = found != run->metrics.end();
      AddCell(text, !there ? "" : std::isnan(found->second) ? "nan" : fmt::format("{}", found->second));
    }
    AddCell(text, run->state_hash), AddCell(text, run->image_hash);
    EndLine(text);
  }
  return text;
}

}  // namespace kestrel::campaign
