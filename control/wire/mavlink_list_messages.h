// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "control/wire/mavlink_fields.h"

// The messages by which a ground station reads and sets parameters and missions, as
// control/wire/mavlink_messages.h has the others.
namespace kestrel::control::wire::mavlink {

struct ParamRequestRead {
  static constexpr std::uint32_t kId = 20;
  static constexpr std::uint8_t kCrcExtra = 214;
  std::int16_t param_index = 0;  // -1: by its name
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<char, 16> param_id{};  // ended by a zero where it is shorter
  bool operator==(const ParamRequestRead&) const = default;
};
template <class Visitor, Either<ParamRequestRead> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.param_index, m.target_system, m.target_component, m.param_id);
}

struct ParamRequestList {
  static constexpr std::uint32_t kId = 21;
  static constexpr std::uint8_t kCrcExtra = 159;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  bool operator==(const ParamRequestList&) const = default;
};
template <class Visitor, Either<ParamRequestList> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.target_system, m.target_component);
}

// A parameter: an answer, to a ParamSet too.
struct ParamValue {
  static constexpr std::uint32_t kId = 22;
  static constexpr std::uint8_t kCrcExtra = 220;
  float param_value = 0;  // or the bytes of a whole number, as the autopilot has it
  std::uint16_t param_count = 0;
  std::uint16_t param_index = 0;  // 65535: in no list
  std::array<char, 16> param_id{};
  std::uint8_t param_type = 0;  // MAV_PARAM_TYPE
  bool operator==(const ParamValue&) const = default;
};
template <class Visitor, Either<ParamValue> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.param_value, m.param_count, m.param_index, m.param_id, m.param_type);
}

struct ParamSet {
  static constexpr std::uint32_t kId = 23;
  static constexpr std::uint8_t kCrcExtra = 168;
  float param_value = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<char, 16> param_id{};
  std::uint8_t param_type = 0;  // MAV_PARAM_TYPE
  bool operator==(const ParamSet&) const = default;
};
template <class Visitor, Either<ParamSet> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.param_value, m.target_system, m.target_component, m.param_id, m.param_type);
}

struct MissionRequest {
  static constexpr std::uint32_t kId = 40;
  static constexpr std::uint8_t kCrcExtra = 230;
  std::uint16_t seq = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  bool operator==(const MissionRequest&) const = default;
};
template <class Visitor, Either<MissionRequest> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.seq, m.target_system, m.target_component);
  v.Extensions(m.mission_type);
}

struct MissionSetCurrent {
  static constexpr std::uint32_t kId = 41;
  static constexpr std::uint8_t kCrcExtra = 28;
  std::uint16_t seq = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  bool operator==(const MissionSetCurrent&) const = default;
};
template <class Visitor, Either<MissionSetCurrent> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.seq, m.target_system, m.target_component);
}

struct MissionCurrent {
  static constexpr std::uint32_t kId = 42;
  static constexpr std::uint8_t kCrcExtra = 28;
  std::uint16_t seq = 0;
  // Since version 2:
  std::uint16_t total = 0;         // 65535: unknown
  std::uint8_t mission_state = 0;  // MISSION_STATE; 1: there is none
  std::uint8_t mission_mode = 0;
  std::uint32_t mission_id = 0;
  std::uint32_t fence_id = 0;
  std::uint32_t rally_points_id = 0;
  bool operator==(const MissionCurrent&) const = default;
};
template <class Visitor, Either<MissionCurrent> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.seq);
  v.Extensions(m.total, m.mission_state, m.mission_mode, m.mission_id, m.fence_id, m.rally_points_id);
}

// How many items a mission has is asked so, and answered with MissionCount, which also offers one.
struct MissionRequestList {
  static constexpr std::uint32_t kId = 43;
  static constexpr std::uint8_t kCrcExtra = 132;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  bool operator==(const MissionRequestList&) const = default;
};
template <class Visitor, Either<MissionRequestList> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.target_system, m.target_component);
  v.Extensions(m.mission_type);
}

struct MissionCount {
  static constexpr std::uint32_t kId = 44;
  static constexpr std::uint8_t kCrcExtra = 221;
  std::uint16_t count = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  std::uint32_t opaque_id = 0;
  bool operator==(const MissionCount&) const = default;
};
template <class Visitor, Either<MissionCount> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.count, m.target_system, m.target_component);
  v.Extensions(m.mission_type, m.opaque_id);
}

struct MissionClearAll {
  static constexpr std::uint32_t kId = 45;
  static constexpr std::uint8_t kCrcExtra = 232;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  bool operator==(const MissionClearAll&) const = default;
};
template <class Visitor, Either<MissionClearAll> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.target_system, m.target_component);
  v.Extensions(m.mission_type);
}

struct MissionAck {
  static constexpr std::uint32_t kId = 47;
  static constexpr std::uint8_t kCrcExtra = 153;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint8_t type = 0;  // MAV_MISSION_RESULT
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  std::uint32_t opaque_id = 0;
  bool operator==(const MissionAck&) const = default;
};
template <class Visitor, Either<MissionAck> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.target_system, m.target_component, m.type);
  v.Extensions(m.mission_type, m.opaque_id);
}

struct MissionRequestInt {
  static constexpr std::uint32_t kId = 51;
  static constexpr std::uint8_t kCrcExtra = 196;
  std::uint16_t seq = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  // Since version 2:
  std::uint8_t mission_type = 0;  // MAV_MISSION_TYPE: 0 mission, 1 fence, 2 rally points
  bool operator==(const MissionRequestInt&) const = default;
};
template <class Visitor, Either<MissionRequestInt> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.seq, m.target_system, m.target_component);
  v.Extensions(m.mission_type);
}

}  // namespace kestrel::control::wire::mavlink
