// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "control/wire/mavlink_fields.h"

// The messages between an autopilot and a ground station, as control/wire/mavlink_messages.h has the others:
// which of them are understood, and what is to be said of each, is there.
namespace kestrel::control::wire::mavlink {

// What works and what does not, of sensors, battery and line.
struct SysStatus {
  static constexpr std::uint32_t kId = 1;
  static constexpr std::uint8_t kCrcExtra = 124;
  std::uint32_t onboard_control_sensors_present = 0;  // MAV_SYS_STATUS_SENSOR bits, as the two below
  std::uint32_t onboard_control_sensors_enabled = 0;
  std::uint32_t onboard_control_sensors_health = 0;
  std::uint16_t load = 0;             // 1e-3
  std::uint16_t voltage_battery = 0;  // mV; 65535: unknown
  std::int16_t current_battery = 0;   // cA; -1: unknown
  std::uint16_t drop_rate_comm = 0;   // 1e-4
  std::uint16_t errors_comm = 0;
  std::uint16_t errors_count1 = 0;
  std::uint16_t errors_count2 = 0;
  std::uint16_t errors_count3 = 0;
  std::uint16_t errors_count4 = 0;
  std::int8_t battery_remaining = 0;  // percent; -1: unknown
  // Since version 2:
  std::uint32_t onboard_control_sensors_present_extended = 0;
  std::uint32_t onboard_control_sensors_enabled_extended = 0;
  std::uint32_t onboard_control_sensors_health_extended = 0;
  bool operator==(const SysStatus&) const = default;
};
template <class Visitor, Either<SysStatus> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.onboard_control_sensors_present, m.onboard_control_sensors_enabled, m.onboard_control_sensors_health,
    m.load, m.voltage_battery, m.current_battery, m.drop_rate_comm, m.errors_comm, m.errors_count1,
    m.errors_count2, m.errors_count3, m.errors_count4, m.battery_remaining);
  v.Extensions(m.onboard_control_sensors_present_extended, m.onboard_control_sensors_enabled_extended,
               m.onboard_control_sensors_health_extended);
}

// Asked and answered, to measure a line.
struct Ping {
  static constexpr std::uint32_t kId = 4;
  static constexpr std::uint8_t kCrcExtra = 237;
  std::uint64_t time_usec = 0;
  std::uint32_t seq = 0;           // counts the questions
  std::uint8_t target_system = 0;  // 0: a question, as with the component
  std::uint8_t target_component = 0;
  bool operator==(const Ping&) const = default;
};
template <class Visitor, Either<Ping> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.seq, m.target_system, m.target_component);
}

struct GpsRawInt {
  static constexpr std::uint32_t kId = 24;
  static constexpr std::uint8_t kCrcExtra = 24;
  std::uint64_t time_usec = 0;
  std::int32_t lat = 0;  // degrees 1e-7, as lon
  std::int32_t lon = 0;
  std::int32_t alt = 0;   // mm above the sea
  std::uint16_t eph = 0;  // HDOP and VDOP 1e-2; 65535: unknown
  std::uint16_t epv = 0;
  std::uint16_t vel = 0;                // cm/s; 65535: unknown
  std::uint16_t cog = 0;                // course, degrees 1e-2; 65535: unknown
  std::uint8_t fix_type = 0;            // 3: of three dimensions
  std::uint8_t satellites_visible = 0;  // 255: unknown
  // Since version 2:
  std::int32_t alt_ellipsoid = 0;  // mm above the ellipsoid
  std::uint32_t h_acc = 0;         // mm, as v_acc; vel_acc mm/s
  std::uint32_t v_acc = 0;
  std::uint32_t vel_acc = 0;
  std::uint32_t hdg_acc = 0;  // degrees 1e-5
  std::uint16_t yaw = 0;      // degrees 1e-2, north is 36000; 0: none, 65535: not now
  bool operator==(const GpsRawInt&) const = default;
};
template <class Visitor, Either<GpsRawInt> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.time_usec, m.lat, m.lon, m.alt, m.eph, m.epv, m.vel, m.cog, m.fix_type, m.satellites_visible);
  v.Extensions(m.alt_ellipsoid, m.h_acc, m.v_acc, m.vel_acc, m.hdg_acc, m.yaw);
}

struct GpsGlobalOrigin {
  static constexpr std::uint32_t kId = 49;
  static constexpr std::uint8_t kCrcExtra = 39;
  std::int32_t latitude = 0;  // degrees 1e-7, as the longitude
  std::int32_t longitude = 0;
  std::int32_t altitude = 0;  // mm above the sea
  // Since version 2:
  std::uint64_t time_usec = 0;
  bool operator==(const GpsGlobalOrigin&) const = default;
};
template <class Visitor, Either<GpsGlobalOrigin> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.latitude, m.longitude, m.altitude);
  v.Extensions(m.time_usec);
}

// Superseded by the command SET_MESSAGE_INTERVAL, and still asked by ground stations.
struct RequestDataStream {
  static constexpr std::uint32_t kId = 66;
  static constexpr std::uint8_t kCrcExtra = 148;
  std::uint16_t req_message_rate = 0;  // Hz
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint8_t req_stream_id = 0;  // MAV_DATA_STREAM
  std::uint8_t start_stop = 0;     // 1 start, 0 stop
  bool operator==(const RequestDataStream&) const = default;
};
template <class Visitor, Either<RequestDataStream> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.req_message_rate, m.target_system, m.target_component, m.req_stream_id, m.start_stop);
}

struct VfrHud {
  static constexpr std::uint32_t kId = 74;
  static constexpr std::uint8_t kCrcExtra = 20;
  float airspeed = 0;  // m/s
  float groundspeed = 0;
  float alt = 0;               // m above the sea
  float climb = 0;             // m/s
  std::int16_t heading = 0;    // degrees
  std::uint16_t throttle = 0;  // percent
  bool operator==(const VfrHud&) const = default;
};
template <class Visitor, Either<VfrHud> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.airspeed, m.groundspeed, m.alt, m.climb, m.heading, m.throttle);
}

// A command at a place.
struct CommandInt {
  static constexpr std::uint32_t kId = 75;
  static constexpr std::uint8_t kCrcExtra = 158;
  float param1 = 0;
  float param2 = 0;
  float param3 = 0;
  float param4 = 0;
  std::int32_t x = 0;  // degrees 1e-7 or 1e-4 m, as y: by its frame
  std::int32_t y = 0;
  float z = 0;  // m
  std::uint16_t command = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint8_t frame = 0;  // MAV_FRAME
  std::uint8_t current = 0;
  std::uint8_t autocontinue = 0;
  bool operator==(const CommandInt&) const = default;
};
template <class Visitor, Either<CommandInt> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.param1, m.param2, m.param3, m.param4, m.x, m.y, m.z, m.command, m.target_system, m.target_component,
    m.frame, m.current, m.autocontinue);
}

struct BatteryStatus {
  static constexpr std::uint32_t kId = 147;
  static constexpr std::uint8_t kCrcExtra = 154;
  std::int32_t current_consumed = 0;         // mAh; -1: unknown
  std::int32_t energy_consumed = 0;          // hJ; -1: unknown
  std::int16_t temperature = 0;              // cdeg C; 32767: unknown
  std::array<std::uint16_t, 10> voltages{};  // mV of each cell; 65535: none
  std::int16_t current_battery = 0;          // cA; -1: unknown
  std::uint8_t id = 0;
  std::uint8_t battery_function = 0;
  std::uint8_t type = 0;
  std::int8_t battery_remaining = 0;  // percent; -1: unknown
  // Since version 2:
  std::int32_t time_remaining = 0;
  std::uint8_t charge_state = 0;
  std::array<std::uint16_t, 4> voltages_ext{};
  std::uint8_t mode = 0;
  std::uint32_t fault_bitmask = 0;
  bool operator==(const BatteryStatus&) const = default;
};
template <class Visitor, Either<BatteryStatus> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.current_consumed, m.energy_consumed, m.temperature, m.voltages, m.current_battery, m.id,
    m.battery_function, m.type, m.battery_remaining);
  v.Extensions(m.time_remaining, m.charge_state, m.voltages_ext, m.mode, m.fault_bitmask);
}

// What it is and what it understands.
struct AutopilotVersion {
  static constexpr std::uint32_t kId = 148;
  static constexpr std::uint8_t kCrcExtra = 178;
  std::uint64_t capabilities = 0;  // MAV_PROTOCOL_CAPABILITY bits
  std::uint64_t uid = 0;
  std::uint32_t flight_sw_version = 0;  // major, minor, patch, FIRMWARE_VERSION_TYPE, a byte each
  std::uint32_t middleware_sw_version = 0;
  std::uint32_t os_sw_version = 0;
  std::uint32_t board_version = 0;
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::array<std::uint8_t, 8> flight_custom_version{};
  std::array<std::uint8_t, 8> middleware_custom_version{};
  std::array<std::uint8_t, 8> os_custom_version{};
  // Since version 2:
  std::array<std::uint8_t, 18> uid2{};
  bool operator==(const AutopilotVersion&) const = default;
};
template <class Visitor, Either<AutopilotVersion> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.capabilities, m.uid, m.flight_sw_version, m.middleware_sw_version, m.os_sw_version, m.board_version,
    m.vendor_id, m.product_id, m.flight_custom_version, m.middleware_custom_version, m.os_custom_version);
  v.Extensions(m.uid2);
}

// To where it returns.
struct HomePosition {
  static constexpr std::uint32_t kId = 242;
  static constexpr std::uint8_t kCrcExtra = 104;
  std::int32_t latitude = 0;  // degrees 1e-7, as the longitude
  std::int32_t longitude = 0;
  std::int32_t altitude = 0;  // mm above the sea
  float x = 0;                // m, in N
  float y = 0;
  float z = 0;
  std::array<float, 4> q{};  // w, x, y, z
  float approach_x = 0;
  float approach_y = 0;
  float approach_z = 0;
  // Since version 2:
  std::uint64_t time_usec = 0;
  bool operator==(const HomePosition&) const = default;
};
template <class Visitor, Either<HomePosition> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.latitude, m.longitude, m.altitude, m.x, m.y, m.z, m.q, m.approach_x, m.approach_y, m.approach_z);
  v.Extensions(m.time_usec);
}

struct MessageInterval {
  static constexpr std::uint32_t kId = 244;
  static constexpr std::uint8_t kCrcExtra = 95;
  std::int32_t interval_us = 0;  // -1: not sent, 0: it has no such message
  std::uint16_t message_id = 0;
  bool operator==(const MessageInterval&) const = default;
};
template <class Visitor, Either<MessageInterval> M>
constexpr void Fields(Visitor& v, M& m) {
  v(m.interval_us, m.message_id);
}

}  // namespace kestrel::control::wire::mavlink
