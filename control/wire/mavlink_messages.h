// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "control/wire/mavlink.h"
#include "control/wire/mavlink_fields.h"
#include "control/wire/mavlink_list_messages.h"
#include "control/wire/mavlink_station_messages.h"
#include "control/wire/mavlink_vision_messages.h"

// The messages between an autopilot, its companion and a simulator: MAVLink's "common" set
// (mavlink.io/en/messages/common.html), as values. Their fields have the names, units and order that they
// have on the wire; each message's Fields says that order once, for writing and reading. N and B are ours:
// its local NED and its body FRD.
namespace kestrel::control::wire::mavlink {

// Who is there, and an autopilot's mode.
struct Heartbeat {
  static constexpr std::uint32_t kId = 0;
  static constexpr std::uint8_t kCrcExtra = 50;
  std::uint32_t custom_mode = 0;   // the autopilot's own modes
  std::uint8_t type = 0;           // MAV_TYPE
  std::uint8_t autopilot = 0;      // MAV_AUTOPILOT
  std::uint8_t base_mode = 0;      // MAV_MODE_FLAG bits
  std::uint8_t system_status = 0;  // MAV_STATE
  std::uint8_t mavlink_version = 3;
  bool operator==(const Heartbeat&) const = default;
};
template <class Visitor, Either<Heartbeat> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.custom_mode, m.type, m.autopilot, m.base_mode, m.system_status, m.mavlink_version);
}

struct SystemTime {
  static constexpr std::uint32_t kId = 2;
  static constexpr std::uint8_t kCrcExtra = 137;
  std::uint64_t time_unix_usec = 0;
  std::uint32_t time_boot_ms = 0;
  bool operator==(const SystemTime&) const = default;
};
template <class Visitor, Either<SystemTime> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_unix_usec, m.time_boot_ms);
}

// Superseded by the command DO_SET_MODE, and still understood.
struct SetMode {
  static constexpr std::uint32_t kId = 11;
  static constexpr std::uint8_t kCrcExtra = 89;
  std::uint32_t custom_mode = 0;
  std::uint8_t target_system = 0;
  std::uint8_t base_mode = 0;
  bool operator==(const SetMode&) const = default;
};
template <class Visitor, Either<SetMode> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.custom_mode, m.target_system, m.base_mode);
}

struct Attitude {
  static constexpr std::uint32_t kId = 30;
  static constexpr std::uint8_t kCrcExtra = 39;
  std::uint32_t time_boot_ms = 0;
  float roll = 0, pitch = 0, yaw = 0;                 // rad
  float rollspeed = 0, pitchspeed = 0, yawspeed = 0;  // rad/s, in B
  bool operator==(const Attitude&) const = default;
};
template <class Visitor, Either<Attitude> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.roll, m.pitch, m.yaw, m.rollspeed, m.pitchspeed, m.yawspeed);
}

struct AttitudeQuaternion {
  static constexpr std::uint32_t kId = 31;
  static constexpr std::uint8_t kCrcExtra = 246;
  std::uint32_t time_boot_ms = 0;
  float q1 = 0, q2 = 0, q3 = 0, q4 = 0;               // R_NB: w, x, y, z
  float rollspeed = 0, pitchspeed = 0, yawspeed = 0;  // rad/s, in B
  // Since version 2:
  std::array<float, 4> repr_offset_q{};  // for display
  bool operator==(const AttitudeQuaternion&) const = default;
};
template <class Visitor, Either<AttitudeQuaternion> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.q1, m.q2, m.q3, m.q4, m.rollspeed, m.pitchspeed, m.yawspeed);
  v.Extensions(m.repr_offset_q);
}

struct LocalPositionNed {
  static constexpr std::uint32_t kId = 32;
  static constexpr std::uint8_t kCrcExtra = 185;
  std::uint32_t time_boot_ms = 0;
  float x = 0, y = 0, z = 0;     // m, in N
  float vx = 0, vy = 0, vz = 0;  // m/s
  bool operator==(const LocalPositionNed&) const = default;
};
template <class Visitor, Either<LocalPositionNed> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz);
}

struct GlobalPositionInt {
  static constexpr std::uint32_t kId = 33;
  static constexpr std::uint8_t kCrcExtra = 104;
  std::uint32_t time_boot_ms = 0;
  std::int32_t lat = 0, lon = 0;        // degrees 1e-7
  std::int32_t alt = 0;                 // mm above the sea
  std::int32_t relative_alt = 0;        // mm above home
  std::int16_t vx = 0, vy = 0, vz = 0;  // cm/s, in N
  std::uint16_t hdg = 0;                // degrees 1e-2; 65535: unknown
  bool operator==(const GlobalPositionInt&) const = default;
};
template <class Visitor, Either<GlobalPositionInt> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.lat, m.lon, m.alt, m.relative_alt, m.vx, m.vy, m.vz, m.hdg);
}

// The pilot's sticks and switches.
struct RcChannels {
  static constexpr std::uint32_t kId = 65;
  static constexpr std::uint8_t kCrcExtra = 118;
  std::uint32_t time_boot_ms = 0;
  std::array<std::uint16_t, 18> chan_raw{};  // us; 65535: unused. In MAVLink chan1_raw to chan18_raw
  std::uint8_t chancount = 0;
  std::uint8_t rssi = 0;  // 255: unknown
  bool operator==(const RcChannels&) const = default;
};
template <class Visitor, Either<RcChannels> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.chan_raw, m.chancount, m.rssi);
}

struct CommandLong {
  static constexpr std::uint32_t kId = 76;
  static constexpr std::uint8_t kCrcExtra = 152;
  float param1 = 0, param2 = 0, param3 = 0, param4 = 0, param5 = 0, param6 = 0,
        param7 = 0;           // what they are is the command's affair
  std::uint16_t command = 0;  // MAV_CMD
  std::uint8_t target_system = 0, target_component = 0;
  std::uint8_t confirmation = 0;  // counts the repetitions of one command
  bool operator==(const CommandLong&) const = default;
};
template <class Visitor, Either<CommandLong> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7, m.command, m.target_system,
    m.target_component, m.confirmation);
}

struct CommandAck {
  static constexpr std::uint32_t kId = 77;
  static constexpr std::uint8_t kCrcExtra = 143;
  std::uint16_t command = 0;
  std::uint8_t result = 0;  // MAV_RESULT
  // Since version 2:
  std::uint8_t progress = 0;  // percent; 255: unknown
  std::int32_t result_param2 = 0;
  std::uint8_t target_system = 0, target_component = 0;
  bool operator==(const CommandAck&) const = default;
};
template <class Visitor, Either<CommandAck> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.command, m.result);
  v.Extensions(m.progress, m.result_param2, m.target_system, m.target_component);
}

struct SetAttitudeTarget {
  static constexpr std::uint32_t kId = 82;
  static constexpr std::uint8_t kCrcExtra = 49;
  std::uint32_t time_boot_ms = 0;
  std::array<float, 4> q{};                                          // R_NB: w, x, y, z
  float body_roll_rate = 0, body_pitch_rate = 0, body_yaw_rate = 0;  // rad/s
  float thrust = 0;                                                  // 0 to 1
  std::uint8_t target_system = 0, target_component = 0;
  std::uint8_t type_mask = 0;  // ATTITUDE_TARGET_TYPEMASK bits
  // Since version 2:
  std::array<float, 3> thrust_body{};  // -1 to 1, in B
  bool operator==(const SetAttitudeTarget&) const = default;
};
template <class Visitor, Either<SetAttitudeTarget> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.q, m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate, m.thrust, m.target_system,
    m.target_component, m.type_mask);
  v.Extensions(m.thrust_body);
}

struct SetPositionTargetLocalNed {
  static constexpr std::uint32_t kId = 84;
  static constexpr std::uint8_t kCrcExtra = 143;
  std::uint32_t time_boot_ms = 0;
  float x = 0, y = 0, z = 0;        // m
  float vx = 0, vy = 0, vz = 0;     // m/s
  float afx = 0, afy = 0, afz = 0;  // m/s^2
  float yaw = 0;                    // rad
  float yaw_rate = 0;               // rad/s
  std::uint16_t type_mask = 0;      // POSITION_TARGET_TYPEMASK bits
  std::uint8_t target_system = 0, target_component = 0;
  std::uint8_t coordinate_frame = 0;  // MAV_FRAME
  bool operator==(const SetPositionTargetLocalNed&) const = default;
};
template <class Visitor, Either<SetPositionTargetLocalNed> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz, m.afx, m.afy, m.afz, m.yaw, m.yaw_rate, m.type_mask,
    m.target_system, m.target_component, m.coordinate_frame);
}

// What the autopilot is following.
struct PositionTargetLocalNed {
  static constexpr std::uint32_t kId = 85;
  static constexpr std::uint8_t kCrcExtra = 140;
  std::uint32_t time_boot_ms = 0;
  float x = 0, y = 0, z = 0;          // m
  float vx = 0, vy = 0, vz = 0;       // m/s
  float afx = 0, afy = 0, afz = 0;    // m/s^2
  float yaw = 0;                      // rad
  float yaw_rate = 0;                 // rad/s
  std::uint16_t type_mask = 0;        // POSITION_TARGET_TYPEMASK bits
  std::uint8_t coordinate_frame = 0;  // MAV_FRAME
  bool operator==(const PositionTargetLocalNed&) const = default;
};
template <class Visitor, Either<PositionTargetLocalNed> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz, m.afx, m.afy, m.afz, m.yaw, m.yaw_rate, m.type_mask,
    m.coordinate_frame);
}

struct HilActuatorControls {
  static constexpr std::uint32_t kId = 93;
  static constexpr std::uint8_t kCrcExtra = 47;
  std::uint64_t time_usec = 0;
  std::uint64_t flags = 0;           // 1: in lockstep
  std::array<float, 16> controls{};  // -1 to 1
  std::uint8_t mode = 0;             // MAV_MODE_FLAG bits
  bool operator==(const HilActuatorControls&) const = default;
};
template <class Visitor, Either<HilActuatorControls> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.flags, m.controls, m.mode);
}

struct HilSensor {
  static constexpr std::uint32_t kId = 107;
  static constexpr std::uint8_t kCrcExtra = 108;
  std::uint64_t time_usec = 0;
  float xacc = 0, yacc = 0, zacc = 0;         // m/s^2, specific force in B
  float xgyro = 0, ygyro = 0, zgyro = 0;      // rad/s, in B
  float xmag = 0, ymag = 0, zmag = 0;         // gauss, in B
  float abs_pressure = 0, diff_pressure = 0;  // hPa
  float pressure_alt = 0;                     // m
  float temperature = 0;                      // degrees Celsius
  std::uint32_t fields_updated = 0;           // which of the above are new
  // Since version 2:
  std::uint8_t id = 0;  // of the sensor
  bool operator==(const HilSensor&) const = default;
};
template <class Visitor, Either<HilSensor> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.xacc, m.yacc, m.zacc, m.xgyro, m.ygyro, m.zgyro, m.xmag, m.ymag, m.zmag, m.abs_pressure,
    m.diff_pressure, m.pressure_alt, m.temperature, m.fields_updated);
  v.Extensions(m.id);
}

struct Timesync {
  static constexpr std::uint32_t kId = 111;
  static constexpr std::uint8_t kCrcExtra = 34;
  std::int64_t tc1 = 0;  // ns; 0: a question
  std::int64_t ts1 = 0;  // ns
  // Since version 2:
  std::uint8_t target_system = 0, target_component = 0;
  bool operator==(const Timesync&) const = default;
};
template <class Visitor, Either<Timesync> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.tc1, m.ts1);
  v.Extensions(m.target_system, m.target_component);
}

struct HilGps {
  static constexpr std::uint32_t kId = 113;
  static constexpr std::uint8_t kCrcExtra = 124;
  std::uint64_t time_usec = 0;
  std::int32_t lat = 0, lon = 0;        // degrees 1e-7
  std::int32_t alt = 0;                 // mm above the sea
  std::uint16_t eph = 0, epv = 0;       // HDOP and VDOP 1e-2; PX4 reads cm
  std::uint16_t vel = 0;                // cm/s
  std::int16_t vn = 0, ve = 0, vd = 0;  // cm/s
  std::uint16_t cog = 0;                // course, degrees 1e-2
  std::uint8_t fix_type = 0;            // 3: of three dimensions
  std::uint8_t satellites_visible = 0;
  // Since version 2:
  std::uint8_t id = 0;
  std::uint16_t yaw = 0;  // degrees 1e-2, north is 36000; 0: unknown
  bool operator==(const HilGps&) const = default;
};
template <class Visitor, Either<HilGps> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.lat, m.lon, m.alt, m.eph, m.epv, m.vel, m.vn, m.ve, m.vd, m.cog, m.fix_type,
    m.satellites_visible);
  v.Extensions(m.id, m.yaw);
}

// The simulator's truth.
struct HilStateQuaternion {
  static constexpr std::uint32_t kId = 115;
  static constexpr std::uint8_t kCrcExtra = 4;
  std::uint64_t time_usec = 0;
  std::array<float, 4> attitude_quaternion{};         // R_NB: w, x, y, z
  float rollspeed = 0, pitchspeed = 0, yawspeed = 0;  // rad/s, in B
  std::int32_t lat = 0, lon = 0;                      // degrees 1e-7
  std::int32_t alt = 0;                               // mm above the sea
  std::int16_t vx = 0, vy = 0, vz = 0;                // cm/s, in N
  std::uint16_t ind_airspeed = 0, true_airspeed = 0;  // cm/s
  std::int16_t xacc = 0, yacc = 0, zacc = 0;          // 1e-3 of 9.80665 m/s^2
  bool operator==(const HilStateQuaternion&) const = default;
};
template <class Visitor, Either<HilStateQuaternion> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.attitude_quaternion, m.rollspeed, m.pitchspeed, m.yawspeed, m.lat, m.lon, m.alt, m.vx,
    m.vy, m.vz, m.ind_airspeed, m.true_airspeed, m.xacc, m.yacc, m.zacc);
}

struct DistanceSensor {
  static constexpr std::uint32_t kId = 132;
  static constexpr std::uint8_t kCrcExtra = 85;
  std::uint32_t time_boot_ms = 0;
  std::uint16_t min_distance = 0, max_distance = 0, current_distance = 0;  // cm
  std::uint8_t type = 0;                                                   // MAV_DISTANCE_SENSOR
  std::uint8_t id = 0;
  std::uint8_t orientation = 0;  // MAV_SENSOR_ORIENTATION; 25: down
  std::uint8_t covariance = 0;   // cm^2; 255: unknown
  // Since version 2:
  float horizontal_fov = 0, vertical_fov = 0;  // rad
  std::array<float, 4> quaternion{};           // of the sensor in B where orientation is custom: w, x, y, z
  std::uint8_t signal_quality = 0;             // percent; 0: unknown, 1: none
  bool operator==(const DistanceSensor&) const = default;
};
template <class Visitor, Either<DistanceSensor> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_boot_ms, m.min_distance, m.max_distance, m.current_distance, m.type, m.id, m.orientation,
    m.covariance);
  v.Extensions(m.horizontal_fov, m.vertical_fov, m.quaternion, m.signal_quality);
}

struct ExtendedSysState {
  static constexpr std::uint32_t kId = 245;
  static constexpr std::uint8_t kCrcExtra = 130;
  std::uint8_t vtol_state = 0;
  std::uint8_t landed_state = 0;  // MAV_LANDED_STATE
  bool operator==(const ExtendedSysState&) const = default;
};
template <class Visitor, Either<ExtendedSysState> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.vtol_state, m.landed_state);
}

struct Statustext {
  static constexpr std::uint32_t kId = 253;
  static constexpr std::uint8_t kCrcExtra = 83;
  std::uint8_t severity = 0;    // 0 emergency to 7 debug
  std::array<char, 50> text{};  // ended by a zero where it is shorter
  // Since version 2:
  std::uint16_t id = 0;  // of a longer text in pieces; 0: whole
  std::uint8_t chunk_seq = 0;
  bool operator==(const Statustext&) const = default;
};
template <class Visitor, Either<Statustext> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.severity, m.text);
  v.Extensions(m.id, m.chunk_seq);
}

using Message =
    std::variant<Heartbeat, SystemTime, SetMode, Attitude, AttitudeQuaternion, LocalPositionNed,
                 GlobalPositionInt, RcChannels, CommandLong, CommandAck, SetAttitudeTarget,
                 SetPositionTargetLocalNed, PositionTargetLocalNed, HilActuatorControls,
                 VisionPositionEstimate, HilSensor, Timesync, HilGps, HilStateQuaternion, DistanceSensor,
                 LandingTarget, ExtendedSysState, Statustext, SysStatus, Ping, ParamRequestRead,
                 ParamRequestList, ParamValue, ParamSet, GpsRawInt, MissionRequest, MissionSetCurrent,
                 MissionCurrent, MissionRequestList, MissionCount, MissionClearAll, MissionAck,
                 GpsGlobalOrigin, MissionRequestInt, RequestDataStream, VfrHud, CommandInt, BatteryStatus,
                 AutopilotVersion, HomePosition, MessageInterval, Odometry, TargetRelative>;

// Of every message above.
std::span<const Format> Formats();

// None: the frame is of another message. What the sender left out is zero, what a later version of the
// message has more is passed over. Any bytes are some value: numbers may be NaN, enumerations unknown.
std::optional<Message> Decode(const Frame& frame);

// Gives the frames of one sender their numbers.
class Sender {
 public:
  Sender(std::uint8_t system, std::uint8_t component) : system_(system), component_(component) {}
  Bytes Encode(const Message& message);

 private:
  std::uint8_t system_, component_;
  std::uint8_t sequence_ = 0;
};

}  // namespace kestrel::control::wire::mavlink
