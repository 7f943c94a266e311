// SPDX-License-Identifier: Apache-2.0
#include "records/page/telemetry_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <unordered_map>
#include <vector>

namespace kestrel::records {
namespace {

using Json = nlohmann::ordered_json;

std::string Quoted(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Whether JSON has a number so; what a stream writes of one that is not finite is a number, too.
enum class Cell { kEmpty, kNumber, kNotFinite, kText };

Cell KindOf(std::string_view cell) {
  if (cell.empty()) return Cell::kEmpty;
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (end != cell.data() + cell.size() || (error != std::errc() && error != std::errc::result_out_of_range))
    return Cell::kText;
  const std::string_view digits = cell.substr(cell[0] == '-' ? 1 : 0);
  if (!std::isdigit(static_cast<unsigned char>(digits[0])))
    return digits[0] == '.' ? Cell::kText : Cell::kNotFinite;
  const bool led =
      digits.size() > 1 && digits[0] == '0' && std::isdigit(static_cast<unsigned char>(digits[1]));
  const std::size_t point = digits.find('.');
  const bool bare =
      point != std::string_view::npos &&
      (point + 1 == digits.size() || !std::isdigit(static_cast<unsigned char>(digits[point + 1])));
  return led || bare ? Cell::kText : Cell::kNumber;  // "007" and "1." are none of JSON's
}

// Row by row, cells with what RFC 4180 allows in quotes.
class Rows {
 public:
  explicit Rows(std::string_view csv) : rest_(csv) {}

  // False: there is none, or its end is not there.
  bool Next(std::vector<std::string>& cells) {
    cells.assign(1, {});
    ++row_;
    bool quoted = false;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const char c = rest_[i];
      if (c == '"') {
        if (quoted && i + 1 < rest_.size() && rest_[i + 1] == '"')
          cells.back() += rest_[i++];
        else
          quoted = !quoted;
      } else if (c == ',' && !quoted) {
        cells.emplace_back();
      } else if (c == '\n' && !quoted) {
        rest_.remove_prefix(i + 1);
        return true;
      } else if (c != '\r' || quoted) {
        cells.back() += c;
      }
    }
    return false;
  }
  std::size_t row() const { return row_; }

 private:
  std::string_view rest_;
  std::size_t row_ = 0;
};

struct Column {
  std::string name;
  std::vector<std::string> cells;
  bool text = false, empty = true;
};

std::string JsonOf(const Column& column) {
  std::string json = column.text ? "{\"words\":[" : "[";
  if (column.text) {
    std::unordered_map<std::string_view, std::size_t> words;
    std::string at;
    for (const std::string& cell : column.cells) {
      if (!at.empty()) at += ',';
      if (cell.empty()) {
        at += "null";
        continue;
      }
      const auto [word, added] = words.try_emplace(cell, words.size());
      if (added) json += (word->second ? "," : "") + Quoted(cell);
      at += fmt::format("{}", word->second);
    }
    return json + "],\"at\":[" + at + "]}";
  }
  for (const std::string& cell : column.cells) {
    if (json.size() > 1) json += ',';
    json += KindOf(cell) == Cell::kNumber ? cell : "null";
  }
  return json + ']';
}

}  // namespace

TelemetryColumnsJson ColumnsOf(std::string_view csv) {
  TelemetryColumnsJson result;
  Rows rows(csv);
  std::vector<std::string> cells;
  std::vector<Column> columns;
  if (!rows.Next(cells)) throw std::runtime_error("it has no first line with the names of its columns");
  for (const std::string& name : cells) columns.push_back({name, {}});
  while (rows.Next(cells)) {
    if (cells.size() != columns.size())
      throw std::runtime_error(
          fmt::format("its row {} has {} cells, its first {}", rows.row(), cells.size(), columns.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell kind = KindOf(cells[i]);
      columns[i].text |= kind == Cell::kText;
      columns[i].empty &= kind == Cell::kEmpty;
      columns[i].cells.push_back(std::move(cells[i]));
    }
    ++result.rows;
  }
  for (const Column& column : columns) {
    if (column.empty) continue;
    result.json +=
        fmt::format("{}{}:{}", result.json.empty() ? "{" : ",", Quoted(column.name), JsonOf(column));
    if (column.name == "t_s" && !column.text && result.rows > 1) {
      const double over_s = std::strtod(column.cells.back().c_str(), nullptr) -
                            std::strtod(column.cells.front().c_str(), nullptr);
      if (over_s > 0) result.rate_hz = static_cast<double>(result.rows - 1) / over_s;
    }
  }
  result.json += result.json.empty() ? "{}" : "}";
  return result;
}

}  // namespace kestrel::records
