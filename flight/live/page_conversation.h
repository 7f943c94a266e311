// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "flight/live/feed.h"

namespace kestrel::flight {

// What a viewer asks of a flight.
struct LiveCommand {
  enum class Op { kPause, kResume, kStep, kSpeed, kChange };
  Op op = Op::kPause;
  double speed = 0;        // of kSpeed
  std::string key, value;  // of kChange: of the scenario, and JSON
  std::int64_t from = 0;   // the viewer who asked
};

// Why viewers cannot command a flight, in words for them; empty: they can.
struct LiveRefusals {
  std::string pace;    // pause, resume, step, speed
  std::string change;  // change
};

// The command in a message of the page. Throws std::invalid_argument with what is wrong, and what is valid.
LiveCommand ParseLiveCommand(std::string_view message);

class PageConversation;

// What the conversations with all pages share.
struct Pages {
  Feed feed;
  LiveRefusals refusals;
  std::function<bool(LiveCommand)> command;       // false: too many wait already
  std::map<std::int64_t, PageConversation*> all;  // by number
  std::int64_t numbered = 0;
};

// With one page.
class PageConversation final : public Conversation {
 public:
  explicit PageConversation(Pages& pages) : pages_(pages), number_(pages.numbered++) {
    pages_.all[number_] = this;
  }
  ~PageConversation() override { pages_.all.erase(number_); }

  void Hear(std::string_view message, bool binary) override;
  void Refuse(const std::string& why) override { Refuse(why, ""); }
  void Refuse(const std::string& why, const std::string& key);  // of a change of that key
  std::optional<LiveMessage> Next() override;

 private:
  Pages& pages_;
  std::int64_t number_;
  Feed::Place place_;
  std::deque<LiveMessage> answers_;
};

}  // namespace kestrel::flight
