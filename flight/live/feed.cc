// SPDX-License-Identifier: Apache-2.0
#include "flight/live/feed.h"

#include <bit>
#include <charconv>
#include <cmath>

namespace kestrel::flight {
namespace {

using nlohmann::json;

constexpr std::size_t kRowsAtOnce = 256;
constexpr std::size_t kMaxTold = 10000;

// The cells of a line, their quotes taken off.
std::vector<std::string> Cells(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

// As it is written where that is a number of JSON, which "01" and ".5" are not.
std::string CellJson(const std::string& cell) {
  if (cell.empty()) return "null";
  double number = 0;
  const auto [end, wrong] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (wrong != std::errc() || end != cell.data() + cell.size()) return TextOf(cell);
  if (!std::isfinite(number)) return "null";
  return json::accept(cell) ? cell : TextOf(cell);
}

}  // namespace

std::string TextOf(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

std::string RowJson(std::string_view line) {
  std::string row = "[";
  for (const std::string& cell : Cells(line)) {
    if (row.size() > 1) row += ',';
    row += CellJson(cell);
  }
  return row + ']';
}

void Feed::Begin(json flight, std::string_view header) {
  const std::int64_t number = flight_ + 1;
  *this = Feed();
  flight_ = number;
  flight["op"] = "flight";
  flight.erase("columns");
  begin_ = TextMessage(TextOf(flight));
  columns_ = TextMessage(TextOf({{"op", "columns"}, {"names", Cells(header)}}));
}

void Feed::Tell(std::string text) {
  if (told_.size() < kMaxTold) told_.push_back(TextMessage(std::move(text)));
}

void Feed::AddEvent(double t_s, std::string_view what, std::string_view is) {
  Tell(TextOf({{"op", "event"}, {"t_s", t_s}, {"what", what}, {"is", is}}));
}

void Feed::AddChange(const std::string& key, const std::string& value, double t_s, const std::string& again) {
  Tell(TextOf({{"op", "changed"},
               {"key", key},
               {"value", json::parse(value, nullptr, false)},
               {"t_s", t_s},
               {"again", again}}));
}

void Feed::SetState(bool paused, double speed, double real_time_factor) {
  state_ = TextMessage(TextOf(
      {{"op", "state"}, {"paused", paused}, {"speed", speed}, {"real_time_factor", real_time_factor}}));
  ++states_;
}

void Feed::AddPicture(Picture kind, double t_s, std::string_view jpeg) {
  static_assert(std::endian::native == std::endian::little, "the time is copied as it is");
  std::string bytes(1, static_cast<char>(kind == Picture::kOnBoard ? 1 : 2));
  bytes.append(reinterpret_cast<const char*>(&t_s), sizeof t_s);
  bytes.append(jpeg);
  Latest& latest = pictures_[static_cast<std::size_t>(kind)];
  ++latest.number;
  latest.message = {std::make_shared<const std::string>(std::move(bytes)), true};
  taken_[static_cast<std::size_t>(kind)] = false;
}

void Feed::End(json summary) {
  summary["op"] = "end";
  end_ = TextMessage(TextOf(summary));
}

LiveMessage Feed::Rows(Place& place) const {
  std::string text = R"({"op":"rows","rows":[)";
  std::size_t count = 0;
  for (const RowStore::Row& row : rows_.From(place.row)) {
    if (count > 0) text += ',';
    text += row.text;
    place.row = row.number + 1;
    if (++count == kRowsAtOnce) break;
  }
  return TextMessage(text + "]}");
}

std::optional<LiveMessage> Feed::Next(Place& place) {
  if (flight_ < 0) return std::nullopt;
  if (place.flight != flight_) {
    place = {.flight = flight_};
    return begin_;
  }
  if (!place.columns) {
    place.columns = true;
    return columns_;
  }
  if (place.row < rows_.given()) return Rows(place);
  if (place.told < told_.size()) return told_[place.told++];
  if (place.state < states_) {
    place.state = states_;
    return state_;
  }
  for (std::size_t kind = 0; kind < pictures_.size(); ++kind) {
    if (place.pictures[kind] == pictures_[kind].number) continue;
    place.pictures[kind] = pictures_[kind].number;
    taken_[kind] = true;
    return pictures_[kind].message;
  }
  if (ended() && !place.end) {
    place.end = true;
    return end_;
  }
  return std::nullopt;
}

}  // namespace kestrel::flight
