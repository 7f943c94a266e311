// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "flight/live/conversation.h"
#include "flight/live/row_store.h"

namespace kestrel::flight {

// What a line of telemetry.csv is as an array of JSON: numbers, texts, null where a cell is empty or no finite
// number.
std::string RowJson(std::string_view line);
// Any text of JSON that the page is sent: what is no UTF-8 is replaced.
std::string TextOf(const nlohmann::json& json);

enum class Picture { kOnBoard, kView };

// What the page is told of a flight (docs/guide/live.md has the messages). Each viewer has its own place in it,
// so that one who comes late or is slow gets every row and event, and of pictures and states the latest.
class Feed {
 public:
  // Where a viewer is.
  struct Place {
    std::int64_t flight = -1;  // all else is of this one
    std::int64_t row = 0;
    std::size_t told = 0;
    std::int64_t state = 0;
    std::array<std::int64_t, 2> pictures{};
    bool columns = false, end = false;
  };

  // flight: of the page's data, without columns; header: the first line of telemetry.csv.
  void Begin(nlohmann::json flight, std::string_view header);
  void AddRow(std::string_view line) { rows_.Add(RowJson(line)); }
  void AddEvent(double t_s, std::string_view what, std::string_view is);
  // value: JSON; again: the command that flies the flight again now.
  void AddChange(const std::string& key, const std::string& value, double t_s, const std::string& again);
  void SetState(bool paused, double speed, double real_time_factor);
  void AddPicture(Picture kind, double t_s, std::string_view jpeg);
  void End(nlohmann::json summary);

  std::optional<LiveMessage> Next(Place& place);
  // Whether somebody has taken the last picture of this kind, and so may want another.
  bool picture_taken(Picture kind) const { return taken_[static_cast<std::size_t>(kind)]; }
  bool ended() const { return end_.bytes != nullptr; }

 private:
  LiveMessage Rows(Place& place) const;
  void Tell(std::string text);

  std::int64_t flight_ = -1;
  LiveMessage begin_, columns_, state_, end_;
  RowStore rows_;
  std::vector<LiveMessage> told_;  // events and changes
  std::int64_t states_ = 0;
  struct Latest {
    std::int64_t number = 0;
    LiveMessage message;
  };
  std::array<Latest, 2> pictures_;
  std::array<bool, 2> taken_{true, true};
};

}  // namespace kestrel::flight
