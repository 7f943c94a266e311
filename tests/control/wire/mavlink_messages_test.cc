// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <random>
#include <sstream>
#include <string>

#include "tests/control/mavlink_frames.h"

namespace kestrel::control::wire::mavlink {
namespace {

// Every message as MAVLink's own description has it, without what version 2 added: type, name, in its order.
struct Description {
  std::uint32_t id;
  const char* name;
  const char* fields;
};
constexpr const char* kPositionTarget =
    " uint16_t type_mask float x float y float z float vx float vy float vz float afx float afy float afz"
    " float yaw float yaw_rate";
std::vector<Description> Descriptions() {
  static const std::string set_position =
      std::string(
          "uint32_t time_boot_ms uint8_t target_system uint8_t target_component"
          " uint8_t coordinate_frame") +
      kPositionTarget;
  static const std::string position =
      std::string("uint32_t time_boot_ms uint8_t coordinate_frame") + kPositionTarget;
  return {
      {0, "HEARTBEAT",
       "uint8_t type uint8_t autopilot uint8_t base_mode uint32_t custom_mode uint8_t system_status"
       " uint8_t mavlink_version"},
      {2, "SYSTEM_TIME", "uint64_t time_unix_usec uint32_t time_boot_ms"},
      {11, "SET_MODE", "uint8_t target_system uint8_t base_mode uint32_t custom_mode"},
      {30, "ATTITUDE",
       "uint32_t time_boot_ms float roll float pitch float yaw float rollspeed float pitchspeed"
       " float yawspeed"},
      {31, "ATTITUDE_QUATERNION",
       "uint32_t time_boot_ms float q1 float q2 float q3 float q4 float rollspeed float pitchspeed"
       " float yawspeed"},
      {32, "LOCAL_POSITION_NED", "uint32_t time_boot_ms float x float y float z float vx float vy float vz"},
      {33, "GLOBAL_POSITION_INT",
       "uint32_t time_boot_ms int32_t lat int32_t lon int32_t alt int32_t relative_alt int16_t vx int16_t vy"
       " int16_t vz uint16_t hdg"},
      {65, "RC_CHANNELS",
       "uint32_t time_boot_ms uint8_t chancount uint16_t chan1_raw uint16_t chan2_raw uint16_t chan3_raw"
       " uint16_t chan4_raw uint16_t chan5_raw uint16_t chan6_raw uint16_t chan7_raw uint16_t chan8_raw"
       " uint16_t chan9_raw uint16_t chan10_raw uint16_t chan11_raw uint16_t chan12_raw uint16_t chan13_raw"
       " uint16_t chan14_raw uint16_t chan15_raw uint16_t chan16_raw uint16_t chan17_raw"
       " uint16_t chan18_raw uint8_t rssi"},
      {76, "COMMAND_LONG",
       "uint8_t target_system uint8_t target_component uint16_t command uint8_t confirmation float param1"
       " float param2 float param3 float param4 float param5 float param6 float param7"},
      {77, "COMMAND_ACK", "uint16_t command uint8_t result"},
      {82, "SET_ATTITUDE_TARGET",
       "uint32_t time_boot_ms uint8_t target_system uint8_t target_component uint8_t type_mask float[4] q"
       " float body_roll_rate float body_pitch_rate float body_yaw_rate float thrust"},
      {84, "SET_POSITION_TARGET_LOCAL_NED", set_position.c_str()},
      {85, "POSITION_TARGET_LOCAL_NED", position.c_str()},
      {93, "HIL_ACTUATOR_CONTROLS", "uint64_t time_usec float[16] controls uint8_t mode uint64_t flags"},
      {102, "VISION_POSITION_ESTIMATE",
       "uint64_t usec float x float y float z float roll float pitch float yaw"},
      {107, "HIL_SENSOR",
       "uint64_t time_usec float xacc float yacc float zacc float xgyro float ygyro float zgyro float xmag"
       " float ymag float zmag float abs_pressure float diff_pressure float pressure_alt float temperature"
       " uint32_t fields_updated"},
      {111, "TIMESYNC", "int64_t tc1 int64_t ts1"},
      {113, "HIL_GPS",
       "uint64_t time_usec uint8_t fix_type int32_t lat int32_t lon int32_t alt uint16_t eph uint16_t epv"
       " uint16_t vel int16_t vn int16_t ve int16_t vd uint16_t cog uint8_t satellites_visible"},
      {115, "HIL_STATE_QUATERNION",
       "uint64_t time_usec float[4] attitude_quaternion float rollspeed float pitchspeed float yawspeed"
       " int32_t lat int32_t lon int32_t alt int16_t vx int16_t vy int16_t vz uint16_t ind_airspeed"
       " uint16_t true_airspeed int16_t xacc int16_t yacc int16_t zacc"},
      {132, "DISTANCE_SENSOR",
       "uint32_t time_boot_ms uint16_t min_distance uint16_t max_distance uint16_t current_distance"
       " uint8_t type uint8_t id uint8_t orientation uint8_t covariance"},
      {149, "LANDING_TARGET",
       "uint64_t time_usec uint8_t target_num uint8_t frame float angle_x float angle_y float distance"
       " float size_x float size_y"},
      {245, "EXTENDED_SYS_STATE", "uint8_t vtol_state uint8_t landed_state"},
      {253, "STATUSTEXT", "uint8_t severity char[50] text"},
      {1, "SYS_STATUS",
       "uint32_t onboard_control_sensors_present uint32_t onboard_control_sensors_enabled uint32_t "
       "onboard_control_sensors_health uint16_t load uint16_t voltage_battery int16_t current_battery int8_t "
       "battery_remaining uint16_t drop_rate_comm uint16_t errors_comm uint16_t errors_count1 uint16_t "
       "errors_count2 uint16_t errors_count3 uint16_t errors_count4"},
      {4, "PING", "uint64_t time_usec uint32_t seq uint8_t target_system uint8_t target_component"},
      {20, "PARAM_REQUEST_READ",
       "uint8_t target_system uint8_t target_component char[16] param_id int16_t param_index"},
      {21, "PARAM_REQUEST_LIST", "uint8_t target_system uint8_t target_component"},
      {22, "PARAM_VALUE",
       "char[16] param_id float param_value uint8_t param_type uint16_t param_count uint16_t param_index"},
      {23, "PARAM_SET",
       "uint8_t target_system uint8_t target_component char[16] param_id float param_value uint8_t "
       "param_type"},
      {24, "GPS_RAW_INT",
       "uint64_t time_usec uint8_t fix_type int32_t lat int32_t lon int32_t alt uint16_t eph uint16_t epv "
       "uint16_t vel uint16_t cog uint8_t satellites_visible"},
      {40, "MISSION_REQUEST", "uint8_t target_system uint8_t target_component uint16_t seq"},
      {41, "MISSION_SET_CURRENT", "uint8_t target_system uint8_t target_component uint16_t seq"},
      {42, "MISSION_CURRENT", "uint16_t seq"},
      {43, "MISSION_REQUEST_LIST", "uint8_t target_system uint8_t target_component"},
      {44, "MISSION_COUNT", "uint8_t target_system uint8_t target_component uint16_t count"},
      {45, "MISSION_CLEAR_ALL", "uint8_t target_system uint8_t target_component"},
      {47, "MISSION_ACK", "uint8_t target_system uint8_t target_component uint8_t type"},
      {49, "GPS_GLOBAL_ORIGIN", "int32_t latitude int32_t longitude int32_t altitude"},
      {51, "MISSION_REQUEST_INT", "uint8_t target_system uint8_t target_component uint16_t seq"},
      {66, "REQUEST_DATA_STREAM",
       "uint8_t target_system uint8_t target_component uint8_t req_stream_id uint16_t req_message_rate "
       "uint8_t start_stop"},
      {74, "VFR_HUD",
       "float airspeed float groundspeed int16_t heading uint16_t throttle float alt float climb"},
      {75, "COMMAND_INT",
       "uint8_t target_system uint8_t target_component uint8_t frame uint16_t command uint8_t current "
       "uint8_t autocontinue float param1 float param2 float param3 float param4 int32_t x int32_t y float "
       "z"},
      {147, "BATTERY_STATUS",
       "uint8_t id uint8_t battery_function uint8_t type int16_t temperature uint16_t[10] voltages int16_t "
       "current_battery int32_t current_consumed int32_t energy_consumed int8_t battery_remaining"},
      {148, "AUTOPILOT_VERSION",
       "uint64_t capabilities uint32_t flight_sw_version uint32_t middleware_sw_version uint32_t "
       "os_sw_version uint32_t board_version uint8_t[8] flight_custom_version uint8_t[8] "
       "middleware_custom_version uint8_t[8] os_custom_version uint16_t vendor_id uint16_t product_id "
       "uint64_t uid"},
      {242, "HOME_POSITION",
       "int32_t latitude int32_t longitude int32_t altitude float x float y float z float[4] q float "
       "approach_x float approach_y float approach_z"},
      {244, "MESSAGE_INTERVAL", "uint16_t message_id int32_t interval_us"},
      {331, "ODOMETRY",
       "uint64_t time_usec uint8_t frame_id uint8_t child_frame_id float x float y float z float[4] q float "
       "vx float vy float vz float rollspeed float pitchspeed float yawspeed float[21] pose_covariance "
       "float[21] velocity_covariance"},
      {511, "TARGET_RELATIVE",
       "uint64_t timestamp uint8_t id uint8_t frame float x float y float z float[3] pos_std float yaw_std "
       "float[4] q_target float[4] q_sensor uint8_t type"},
  };
}

struct Field {
  std::string type, name;
  std::size_t size = 0, count = 0;  // 0: no array
};

std::vector<Field> Parse(const char* text) {
  static const std::map<std::string, std::size_t> sizes{
      {"char", 1},     {"int8_t", 1},  {"uint8_t", 1}, {"uint16_t", 2}, {"int16_t", 2},
      {"uint32_t", 4}, {"int32_t", 4}, {"float", 4},   {"uint64_t", 8}, {"int64_t", 8}};
  std::istringstream stream(text);
  std::vector<Field> fields;
  for (Field field; stream >> field.type >> field.name;) {
    field.count = 0;
    if (const auto bracket = field.type.find('['); bracket != std::string::npos) {
      field.count = std::stoul(field.type.substr(bracket + 1));
      field.type.resize(bracket);
    }
    field.size = sizes.at(field.type);
    fields.push_back(field);
  }
  return fields;
}

// mavlink.io/en/guide/serialization.html, "CRC_EXTRA calculation", with a check sum of its own.
std::uint8_t CrcExtra(const std::string& name, std::vector<Field> fields) {
  std::uint16_t crc = 0xFFFF;
  const auto add = [&crc](const std::string& text) {
    for (const char c : text) {
      crc ^= static_cast<std::uint8_t>(c);
      for (int bit = 0; bit < 8; ++bit)
        crc = static_cast<std::uint16_t>(crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1);
    }
  };
  std::ranges::stable_sort(fields, std::ranges::greater{}, &Field::size);
  add(name + " ");
  for (const Field& field : fields) {
    add(field.type + " " + field.name + " ");
    if (field.count > 0) add(std::string(1, static_cast<char>(field.count)));
  }
  return static_cast<std::uint8_t>((crc & 0xFF) ^ crc >> 8);
}

TEST(MavlinkMessages, TheirChecksAndLengthsFollowFromTheirFields) {
  const std::vector<Description> descriptions = Descriptions();
  ASSERT_EQ(Formats().size(), descriptions.size());
  for (const auto& [id, name, text] : descriptions) {
    const auto format = std::ranges::find(Formats(), id, &Format::id);
    ASSERT_NE(format, Formats().end()) << name;
    const std::vector<Field> fields = Parse(text);
    EXPECT_EQ(format->crc_extra, CrcExtra(name, fields)) << name;
    std::size_t length = 0;
    for (const Field& field : fields) length += field.size * std::max<std::size_t>(field.count, 1);
    EXPECT_EQ(format->base_length, length) << name;
  }
}

TEST(MavlinkMessages, TheirChecksAndLengthsAreThePublishedOnes) {
  struct Published {
    std::uint32_t id;
    std::uint8_t length, base_length, crc_extra;
  };
  for (const auto& [id, length, base_length, crc_extra] : std::vector<Published>{
           {0, 9, 9, 50},      {2, 12, 12, 137},   {11, 6, 6, 89},      {30, 28, 28, 39},
           {31, 48, 32, 246},  {32, 28, 28, 185},  {33, 28, 28, 104},   {65, 42, 42, 118},
           {76, 33, 33, 152},  {77, 10, 3, 143},   {82, 51, 39, 49},    {84, 53, 53, 143},
           {85, 51, 51, 140},  {93, 81, 81, 47},   {102, 117, 32, 158}, {107, 65, 64, 108},
           {111, 18, 16, 34},  {113, 39, 36, 124}, {115, 64, 64, 4},    {132, 39, 14, 85},
           {149, 60, 30, 200}, {245, 2, 2, 130},   {253, 54, 51, 83},   {1, 43, 31, 124},
           {4, 14, 14, 237},   {20, 20, 20, 214},  {21, 2, 2, 159},     {22, 25, 25, 220},
           {23, 23, 23, 168},  {24, 52, 30, 24},   {40, 5, 4, 230},     {41, 4, 4, 28},
           {42, 18, 2, 28},    {43, 3, 2, 132},    {44, 9, 4, 221},     {45, 3, 2, 232},
           {47, 8, 3, 153},    {49, 20, 12, 39},   {51, 5, 4, 196},     {66, 6, 6, 148},
           {74, 20, 20, 20},   {75, 35, 35, 158},  {147, 54, 36, 154},  {148, 78, 60, 178},
           {242, 60, 52, 104}, {244, 6, 6, 95},    {331, 233, 230, 91}, {511, 71, 71, 28}}) {
    const auto format = std::ranges::find(Formats(), id, &Format::id);
    ASSERT_NE(format, Formats().end()) << id;
    EXPECT_EQ(format->length, length) << id;
    EXPECT_EQ(format->base_length, base_length) << id;
    EXPECT_EQ(format->crc_extra, crc_extra) << id;
  }
}

// The payload of a message whose fields are all zero but one, which is at this offset.
template <class T>
void ExpectAt(std::size_t offset, T value, const Message& message) {
  std::array<std::uint8_t, 255> expected{};
  const auto raw = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
  std::ranges::copy(raw, expected.begin() + static_cast<std::ptrdiff_t>(offset));
  const Bytes bytes = Sender(1, 1).Encode(message);
  std::array<std::uint8_t, 255> payload{};
  std::copy_n(bytes.begin() + 10, bytes[1], payload.begin());
  EXPECT_EQ(payload, expected) << "message " << int{bytes[7]} << " offset " << offset;
}

TEST(MavlinkMessages, FieldsAreWhereTheTablesHaveThem) {
  static_assert(std::endian::native == std::endian::little);
  const std::uint8_t u8 = 0xA1;
  const std::uint16_t u16 = 0xA1B2;
  const std::int16_t i16 = -12345;
  const std::uint32_t u32 = 0xA1B2C3D4;
  const std::int32_t i32 = -1234567890;
  const float f = -1.2345F;
  ExpectAt(0, u32, Heartbeat{.custom_mode = u32, .mavlink_version = 0});
  ExpectAt(5, u8, Heartbeat{.autopilot = u8, .mavlink_version = 0});
  ExpectAt(6, u8, Heartbeat{.base_mode = u8, .mavlink_version = 0});
  ExpectAt(8, u8, Heartbeat{.mavlink_version = u8});
  ExpectAt(4, f, AttitudeQuaternion{.q1 = f});
  ExpectAt(16, f, AttitudeQuaternion{.q4 = f});
  ExpectAt(28, f, AttitudeQuaternion{.yawspeed = f});
  ExpectAt(44, f, AttitudeQuaternion{.repr_offset_q = {0, 0, 0, f}});
  ExpectAt(12, f, LocalPositionNed{.z = f});
  ExpectAt(24, f, LocalPositionNed{.vz = f});
  ExpectAt(12, i32, GlobalPositionInt{.alt = i32});
  ExpectAt(24, i16, GlobalPositionInt{.vz = i16});
  ExpectAt(26, u16, GlobalPositionInt{.hdg = u16});
  ExpectAt(24, f, CommandLong{.param7 = f});
  ExpectAt(28, u16, CommandLong{.command = u16});
  ExpectAt(30, u8, CommandLong{.target_system = u8});
  ExpectAt(32, u8, CommandLong{.confirmation = u8});
  ExpectAt(2, u8, CommandAck{.result = u8});
  ExpectAt(4, i32, CommandAck{.result_param2 = i32});
  ExpectAt(9, u8, CommandAck{.target_component = u8});
  ExpectAt(16, f, SetAttitudeTarget{.q = {0, 0, 0, f}});
  ExpectAt(28, f, SetAttitudeTarget{.body_yaw_rate = f});
  ExpectAt(32, f, SetAttitudeTarget{.thrust = f});
  ExpectAt(38, u8, SetAttitudeTarget{.type_mask = u8});
  ExpectAt(12, f, SetPositionTargetLocalNed{.z = f});
  ExpectAt(24, f, SetPositionTargetLocalNed{.vz = f});
  ExpectAt(36, f, SetPositionTargetLocalNed{.afz = f});
  ExpectAt(40, f, SetPositionTargetLocalNed{.yaw = f});
  ExpectAt(44, f, SetPositionTargetLocalNed{.yaw_rate = f});
  ExpectAt(48, u16, SetPositionTargetLocalNed{.type_mask = u16});
  ExpectAt(51, u8, SetPositionTargetLocalNed{.target_component = u8});
  ExpectAt(52, u8, SetPositionTargetLocalNed{.coordinate_frame = u8});
  ExpectAt(50, u8, PositionTargetLocalNed{.coordinate_frame = u8});
  ExpectAt(8, std::int64_t{-1}, Timesync{.ts1 = -1});
  ExpectAt(17, u8, Timesync{.target_component = u8});
  ExpectAt(8, u16, DistanceSensor{.current_distance = u16});
  ExpectAt(13, u8, DistanceSensor{.covariance = u8});
  ExpectAt(38, u8, DistanceSensor{.signal_quality = u8});
  ExpectAt(16, f, LandingTarget{.distance = f});
  ExpectAt(29, u8, LandingTarget{.frame = u8});
  ExpectAt(38, f, LandingTarget{.z = f});
  ExpectAt(54, f, LandingTarget{.q = {0, 0, 0, f}});
  ExpectAt(59, u8, LandingTarget{.position_valid = u8});
  ExpectAt(28, f, HilSensor{.zgyro = f});
  ExpectAt(40, f, HilSensor{.zmag = f});
  ExpectAt(44, f, HilSensor{.abs_pressure = f});
  ExpectAt(56, f, HilSensor{.temperature = f});
  ExpectAt(60, u32, HilSensor{.fields_updated = u32});
  ExpectAt(64, u8, HilSensor{.id = u8});
  ExpectAt(22, u16, HilGps{.epv = u16});
  ExpectAt(30, i16, HilGps{.vd = i16});
  ExpectAt(35, u8, HilGps{.satellites_visible = u8});
  ExpectAt(37, u16, HilGps{.yaw = u16});
  ExpectAt(20, f, HilStateQuaternion{.attitude_quaternion = {0, 0, 0, f}});
  ExpectAt(44, i32, HilStateQuaternion{.alt = i32});
  ExpectAt(52, i16, HilStateQuaternion{.vz = i16});
  ExpectAt(56, u16, HilStateQuaternion{.true_airspeed = u16});
  ExpectAt(62, i16, HilStateQuaternion{.zacc = i16});
  ExpectAt(8, std::uint64_t{1}, HilActuatorControls{.flags = 1});
  HilActuatorControls controls;
  controls.controls[15] = f;
  ExpectAt(76, f, controls);
  ExpectAt(80, u8, HilActuatorControls{.mode = u8});
}

// Any payload is some value, and no bit of it is lost.
TEST(MavlinkMessages, WhatIsReadIsWritten) {
  std::mt19937 random(1);
  for (const Format& format : Formats()) {
    for (int round = 0; round < 500; ++round) {
      Frame frame{.sequence = 0, .system = 7, .component = 9, .id = format.id, .length = format.length};
      for (int i = 0; i < format.length; ++i)
        frame.payload[static_cast<std::size_t>(i)] =
            round % 3 == 0 && i > format.length / 2 ? 0 : static_cast<std::uint8_t>(random());
      const std::optional<Message> message = Decode(frame);
      ASSERT_TRUE(message);
      ASSERT_EQ(Sender(7, 9).Encode(*message), EncodeFrame(frame, format.crc_extra)) << format.id;
    }
  }
}

TEST(MavlinkMessages, ZerosAtTheEndAreNotSent) {
  const Bytes bytes = Sender(1, 1).Encode(SystemTime{.time_unix_usec = 0x1234, .time_boot_ms = 0});
  EXPECT_EQ(bytes.size(), 12U + 2U);
  EXPECT_EQ(bytes[1], 2);
  // The first byte is, whatever it is.
  EXPECT_EQ(Sender(1, 1).Encode(SystemTime{}).size(), 12U + 1U);
}

TEST(MavlinkMessages, WhatWasNotSentIsZeroAndWhatIsNewIsPassedOver) {
  Parser parser(Formats());
  // Nothing at all.
  auto frames = parser.Datagram(WithChecksum({0xFD, 0, 0, 0, 5, 1, 1, 2, 0, 0}, 137));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(Decode(frames[0]) == Message(SystemTime{}));
  // Two bytes of a number of four.
  frames =
      parser.Datagram(WithChecksum({0xFD, 10, 0, 0, 6, 1, 1, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2, 3}, 137));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(Decode(frames[0]) == Message(SystemTime{.time_unix_usec = 1, .time_boot_ms = 0x0302}));
  // A field more than we know of.
  frames = parser.Datagram(
      WithChecksum({0xFD, 14, 0, 0, 7, 1, 1, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 9, 9}, 137));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(Decode(frames[0]) == Message(SystemTime{.time_unix_usec = 1, .time_boot_ms = 2}));
  EXPECT_EQ(parser.counts().stray_bytes, 0U);
}

TEST(MavlinkMessages, AFrameOfAnotherMessageIsNone) { EXPECT_FALSE(Decode(Frame{.id = 0x10000})); }

TEST(MavlinkMessages, ASenderNumbersItsFrames) {
  Sender sender(1, 1);
  for (int i = 0; i < 600; ++i) EXPECT_EQ(sender.Encode(Heartbeat{})[4], i % 256);
}

}  // namespace
}  // namespace kestrel::control::wire::mavlink
