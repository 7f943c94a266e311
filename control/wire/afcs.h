// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/yaml/fields.h"
#include "control/wire/bytes.h"

// The datagrams of the Rotomotion AFCS autopilots (SRA1 with AFCS 2.5, SR20 with 3.4), AFCS-LIKE, UNVERIFIED
// AGAINST HARDWARE: no document of theirs is public. The messages and their fields are those of the thesis,
// B.1.1; numbers of the types, order of the header's bytes and the receiver's rules are those of a later
// public client of that interface, and the order of the payload's bytes is that of the x86 processors they
// ran on. A field report has sizes that differ from the vendor's own papers (140 bytes for 112), so all of it
// is data: an AfcsProfile, which a file may replace. A datagram's length is its only mark of a version and
// must be exact.
//
// A datagram is seconds, microseconds, type, payload. Nothing in it is a check sum: damage to a payload that
// UDP's own sum lets through is not seen here, and numbers are not looked at (NaN may stand in a field that
// the mode does not use).
namespace kestrel::control::wire {

// When it was sent. Receivers drop what bears the time of another: see After.
struct AfcsTime {
  std::uint32_t seconds = 0, microseconds = 0;  // microseconds < 1000000
  auto operator<=>(const AfcsTime&) const = default;
};
// The time to send with: now, or the next microsecond after the last that was sent.
AfcsTime After(const AfcsTime& last, const AfcsTime& now);
// To the nearest microsecond; before 0: 0.
AfcsTime AfcsTimeOf(double t_s);
double Seconds(const AfcsTime& time);

struct AfcsOpen {  // begins a session; acknowledged
  bool operator==(const AfcsOpen&) const = default;
};
struct AfcsAck {
  std::uint32_t acknowledged = 0;  // type of the message
  bool operator==(const AfcsAck&) const = default;
};
struct AfcsClose {  // ends a session
  bool operator==(const AfcsClose&) const = default;
};

// Units are not stated: SI and radians, N and B are assumed.
struct AfcsState {
  double phi = 0, theta = 0, psi = 0;      // rad
  double p = 0, q = 0, r = 0;              // rad/s, in B
  double x = 0, y = 0, z = 0;              // m, in N
  double vx = 0, vy = 0, vz = 0;           // m/s, in N
  double mx = 0, my = 0, mz = 0;           // magnetometer, raw
  double ax = 0, ay = 0, az = 0;           // m/s^2, in B
  double raw_p = 0, raw_q = 0, raw_r = 0;  // body rates, raw
  double trace = 0;                        // of the filter's covariance
  double voltage = 0;                      // V
  std::uint16_t resets = 0, rpm0 = 0, rpm1 = 0, rpm2 = 0;
  bool operator==(const AfcsState&) const = default;
};

struct AfcsGpsState {
  std::int16_t numsv = 0, sacc = 0, pacc = 0, fixtype = 0;
  double vel_n = 0, vel_e = 0, vel_d = 0;  // m/s
  double pos_n = 0, pos_e = 0, pos_d = 0;  // m
  double lat = 0, lon = 0, alt = 0;        // AFCS 2.5: raw position n, e, d
  double trace = 0;
  bool operator==(const AfcsGpsState&) const = default;
};

struct AfcsFlyTo {
  std::int16_t pos_mode = 0, hdg_mode = 0, transit_time = 0;  // values unknown
  double x = 0, y = 0, z = 0;                                 // m, in N
  double hdg = 0;                                             // rad
  bool operator==(const AfcsFlyTo&) const = default;
};

// "Roughly in m/s, but depend on the actual steady state offsets. Very small values may actually cause the
// aircraft to move backwards."
struct AfcsTeleop {
  double fore = 0, side = 0, alt = 0, hdg = 0;
  bool operator==(const AfcsTeleop&) const = default;
};

struct AfcsDesiredPosition {   // answers AfcsFlyTo
  double n = 0, e = 0, d = 0;  // m
  double hdg = 0;              // rad
  bool operator==(const AfcsDesiredPosition&) const = default;
};

struct AfcsPlatform {     // the pan-tilt platform of the camera; the answer has every field
  std::int16_t mode = 0;  // values unknown
  double relative_roll = 0, relative_pitch = 0, relative_yaw = 0;
  double absolute_roll = 0, absolute_pitch = 0, absolute_yaw = 0;
  double camera_n = 0, camera_e = 0, camera_d = 0;
  bool operator==(const AfcsPlatform&) const = default;
};

using AfcsMessage = std::variant<AfcsOpen, AfcsAck, AfcsClose, AfcsState, AfcsGpsState, AfcsFlyTo, AfcsTeleop,
                                 AfcsDesiredPosition, AfcsPlatform>;
// Their names in a profile.
inline constexpr std::array<const char*, std::variant_size_v<AfcsMessage>> kAfcsMessageNames = {
    "open", "ack", "close", "state", "gps_state", "fly_to", "teleop", "desired_position", "platform"};

// A number of a payload. Its name is that of the struct's member, or begins with "pad".
struct AfcsField {
  std::string name, type;
};
struct AfcsLayout {
  std::string name;  // of kAfcsMessageNames
  int id = 0;
  std::string byte_order = "little";
  std::vector<AfcsField> fields;
};
struct AfcsProfile {
  std::string name;
  std::string header_byte_order = "big";
  int time_bytes = 4;                // 8 as 64-bit hosts have them
  std::vector<AfcsLayout> messages;  // all of kAfcsMessageNames
};

// "thesis": B.1.1 in network order at the head and little-endian behind it, ids of the public client.
AfcsProfile ThesisAfcsProfile();
// All that is wrong with a profile, by line.
std::vector<std::string> MistakesOf(const AfcsProfile& profile);

inline void Fields(FieldVisitor& v, AfcsField& f) {
  v(Required("name", "quantity of the message, or a name that begins with pad: sent as 0 and not read"),
    f.name);
  v(Required("type", "number format on the wire: signed, unsigned or floating-point, and its bits"), f.type,
    {"i16", "u16", "i32", "u32", "f32", "f64"});
}
inline void Fields(FieldVisitor& v, AfcsLayout& m) {
  v(Required("name",
             "message: open, ack, close, state, gps_state, fly_to, teleop, desired_position or platform"),
    m.name);
  v(Required("id", "number of the message's type on the wire"), m.id, 0, 256);
  v({"byte_order", "byte order of the message's payload"}, m.byte_order, {"little", "big"});
  v({"fields",
     "numbers of the payload in their order; a quantity that is missing is not sent and reads as 0"},
    m.fields);
}
inline void Fields(FieldVisitor& v, AfcsProfile& p) {
  v(Required("name", "name of the layout, for messages about mistakes in it"), p.name);
  v({"header_byte_order", "byte order of the header of every datagram"}, p.header_byte_order,
    {"little", "big"});
  v({"time_bytes", "bytes of each half of the time stamp (seconds, microseconds): 4 or 8"}, p.time_bytes, 4,
    8);
  v({"messages", "layouts of all nine messages, each given once"}, p.messages);
}

enum class AfcsRefusal {
  kShort,      // not even a header
  kTime,       // more than 999999 microseconds, or seconds beyond 32 bits
  kType,       // above 256: invalid
  kUnknown,    // a type that the profile does not have
  kLength,     // not exactly that of the type
  kRange,      // a number that the message's integer cannot hold; only where a profile has another type
  kDuplicate,  // the time of the last accepted datagram, or of the last of its type
  kOld,        // before the last accepted of its type
};
inline constexpr std::size_t kAfcsRefusals = 8;

struct AfcsDatagram {
  AfcsTime time;
  AfcsMessage message;
  bool operator==(const AfcsDatagram&) const = default;
};

class AfcsCodec {
 public:
  // Throws std::invalid_argument with all MistakesOf the profile.
  explicit AfcsCodec(const AfcsProfile& profile);
  // Integers of the wire take the nearest value that they can hold, and 0 for no number.
  Bytes Encode(const AfcsDatagram& datagram) const;
  std::variant<AfcsDatagram, AfcsRefusal> Decode(std::span<const std::uint8_t> bytes) const;
  std::size_t header_bytes() const;
  // Header and payload of the message with this place in kAfcsMessageNames.
  std::size_t datagram_bytes(std::size_t index) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;  // never changes, so copies share it
};

// The rules for what one peer sends. A peer whose clock went back is heard again after Reset.
class AfcsReceiver {
 public:
  explicit AfcsReceiver(AfcsCodec codec) : codec_(std::move(codec)) {}
  std::optional<AfcsDatagram> Receive(std::span<const std::uint8_t> bytes);
  void Reset();  // a new session: forgets the times

  std::uint64_t accepted() const { return accepted_; }
  std::uint64_t refused(AfcsRefusal why) const { return refused_[static_cast<std::size_t>(why)]; }

 private:
  AfcsCodec codec_;
  std::optional<AfcsTime> last_;
  std::array<std::optional<AfcsTime>, std::variant_size_v<AfcsMessage>> last_of_type_{};
  std::uint64_t accepted_ = 0;
  std::array<std::uint64_t, kAfcsRefusals> refused_{};
};

}  // namespace kestrel::control::wire
