// SPDX-License-Identifier: Apache-2.0
#include "flight/live/page_conversation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "base/printable.h"
#include "flight/live/pace.h"

namespace kestrel::flight {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxAnswers = 64;  // that wait for a viewer who does not read them
constexpr std::size_t kMaxKey = 200;

}  // namespace

LiveCommand ParseLiveCommand(std::string_view message) {
  const json parsed = json::parse(message, nullptr, false);
  if (!parsed.is_object()) throw std::invalid_argument("that is no object of JSON; valid: {\"op\": ...}");
  const auto op = parsed.find("op");
  if (op == parsed.end() || !op->is_string())
    throw std::invalid_argument("it has no \"op\"; valid: pause, resume, step, speed, change");
  using Op = LiveCommand::Op;
  constexpr std::array<std::pair<std::string_view, Op>, 5> kOps{{{"pause", Op::kPause},
                                                                 {"resume", Op::kResume},
                                                                 {"step", Op::kStep},
                                                                 {"speed", Op::kSpeed},
                                                                 {"change", Op::kChange}}};
  LiveCommand command;
  const std::string& name = op->get_ref<const std::string&>();
  const auto* found =
      std::ranges::find(kOps, std::string_view(name), &std::pair<std::string_view, Op>::first);
  if (found == kOps.end())
    throw std::invalid_argument(fmt::format("'{}' is no command; valid: pause, resume, step, speed, change",
                                            Printable(name.substr(0, kMaxKey))));
  command.op = found->second;
  const auto value = parsed.find("value");
  if (command.op == Op::kSpeed) {
    if (value == parsed.end() || !value->is_number() || !Pace::Valid(value->get<double>()))
      throw std::invalid_argument(
          fmt::format("that is no speed; valid: {:g} to {:g} times real time, or {:g} for as fast as it goes",
                      Pace::kLeast, Pace::kMost, Pace::kAsFast));
    command.speed = value->get<double>();
  }
  if (command.op == Op::kChange) {
    const auto key = parsed.find("key");
    if (key == parsed.end() || !key->is_string() || key->get_ref<const std::string&>().empty() ||
        key->get_ref<const std::string&>().size() > kMaxKey)
      throw std::invalid_argument("a change has a \"key\" of the scenario");
    if (value == parsed.end()) throw std::invalid_argument("a change has a \"value\"");
    command.key = *key;
    command.value = TextOf(*value);
  }
  return command;
}

void PageConversation::Hear(std::string_view message, bool binary) {
  if (binary) return Refuse("commands are text of JSON, not binary");
  try {
    LiveCommand command = ParseLiveCommand(message);
    const std::string& refusal =
        command.op == LiveCommand::Op::kChange ? pages_.refusals.change : pages_.refusals.pace;
    if (pages_.feed.ended()) return Refuse("the flight is over", command.key);
    if (!refusal.empty()) return Refuse(refusal, command.key);
    command.from = number_;
    if (!pages_.command(std::move(command))) Refuse("the flight has too much to do; valid: later");
  } catch (const std::invalid_argument& e) {
    Refuse(e.what());
  }
}

void PageConversation::Refuse(const std::string& why, const std::string& key) {
  if (answers_.size() < kMaxAnswers)
    answers_.push_back(TextMessage(TextOf({{"op", "refused"}, {"why", why}, {"key", key}})));
}

std::optional<LiveMessage> PageConversation::Next() {
  if (answers_.empty()) return pages_.feed.Next(place_);
  LiveMessage answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

}  // namespace kestrel::flight
