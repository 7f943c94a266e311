// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_missions.h"

#include <type_traits>
#include <variant>

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;

// MAV_MISSION_RESULT
constexpr std::uint8_t kMissionAccepted = 0, kMissionUnsupported = 3, kNoSuchItem = 13;

template <class M>
constexpr bool kAsked = std::is_same_v<M, MissionRequestList> || std::is_same_v<M, MissionCount> ||
                        std::is_same_v<M, MissionClearAll> || std::is_same_v<M, MissionRequest> ||
                        std::is_same_v<M, MissionRequestInt> || std::is_same_v<M, MissionSetCurrent>;

MissionAck Ack(std::uint8_t result, std::uint8_t mission_type, const Source& from) {
  return {.target_system = from.first,
          .target_component = from.second,
          .type = result,
          .mission_type = mission_type};
}

}  // namespace

std::optional<MissionQuestion> AsMissionQuestion(const Message& message) {
  return std::visit(
      []<class M>(const M& m) -> std::optional<MissionQuestion> {
        if constexpr (kAsked<M>) return MissionQuestion{m.target_system, m.target_component};
        return std::nullopt;
      },
      message);
}

MissionAnswer AnswerMission(const Message& message, const Source& from) {
  if (const auto* list = std::get_if<MissionRequestList>(&message))
    return {
        MissionCount{
            .target_system = from.first, .target_component = from.second, .mission_type = list->mission_type},
        {}};
  if (const auto* offered = std::get_if<MissionCount>(&message)) {
    if (offered->count == 0) return {Ack(kMissionAccepted, offered->mission_type, from), {}};
    return {Ack(kMissionUnsupported, offered->mission_type, from), "refused: missions are not emulated"};
  }
  if (const auto* clear = std::get_if<MissionClearAll>(&message))
    return {Ack(kMissionAccepted, clear->mission_type, from), {}};
  if (const auto* item = std::get_if<MissionRequest>(&message))
    return {Ack(kNoSuchItem, item->mission_type, from), "refused: there is no mission"};
  if (const auto* item = std::get_if<MissionRequestInt>(&message))
    return {Ack(kNoSuchItem, item->mission_type, from), "refused: there is no mission"};
  return {std::nullopt, "refused: there is no mission"};
}

}  // namespace kestrel::sim
