// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "control/wire/mavlink_messages.h"

// An emulated autopilot has no mission, fence or rally points. Their lists are empty, clearing them is done at once, and
// what would fill them is refused.
namespace kestrel::sim {

struct MissionQuestion {
  std::uint8_t target_system = 0, target_component = 0;
};
// None: it is no message about missions that is answered.
std::optional<MissionQuestion> AsMissionQuestion(const control::wire::mavlink::Message& message);

struct MissionAnswer {
  std::optional<control::wire::mavlink::Message> message;
  std::string text;  // why something is refused; empty: nothing is
};
// Of a message that is such a question, to who asked.
MissionAnswer AnswerMission(const control::wire::mavlink::Message& message,
                            const control::wire::mavlink::Source& from);

}  // namespace kestrel::sim
