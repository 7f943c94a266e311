// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_telling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;
using control::FlightMode;

constexpr std::uint16_t kSwitchOn_us = 2000, kSwitchOff_us = 1000, kCentre_us = 1500, kUnused_us = 65535;
constexpr std::uint16_t kUnknown16 = 65535;
constexpr std::uint8_t kUnknown8 = 255;
// MAV_LANDED_STATE
constexpr std::uint8_t kOnGround = 1, kInAir = 2, kTakingOff = 3, kLanding = 4;
// MAV_DATA_STREAM
constexpr std::uint8_t kStatusStream = 2, kRcStream = 3, kPositionStream = 6, kExtra1Stream = 10,
                       kExtra2Stream = 11, kExtra3Stream = 12;
// MAV_SYS_STATUS_SENSOR: gyros, accelerometers, magnetometer, barometer, GPS, the control of rates, attitude, yaw,
// height and place, motors, the pilot's channels, attitude and heading, checks before arming.
constexpr std::uint32_t kParts = 0x1 | 0x2 | 0x4 | 0x8 | 0x20 | 0x400 | 0x800 | 0x1000 | 0x2000 | 0x4000 |
                                 0x8000 | 0x10000 | 0x200000 | 0x10000000;
// MAV_PROTOCOL_CAPABILITY: whole numbers in commands, setpoints of attitude and place, version 2.
constexpr std::uint64_t kAble = 0x8 | 0x40 | 0x80 | 0x2000, kParamBytes = 0x10, kParamCast = 0x20000;
constexpr std::uint32_t kOfficial = 255;  // FIRMWARE_VERSION_TYPE
constexpr std::uint32_t Release(std::uint32_t major, std::uint32_t minor, std::uint32_t patch) {
  return major << 24 | minor << 16 | patch << 8 | kOfficial;
}
constexpr std::uint8_t kNoMission = 1;  // MISSION_STATE

constexpr std::array kOffers{
    MavlinkOffer{SysStatus::kId, 1, kStatusStream},
    MavlinkOffer{SystemTime::kId, 1, kExtra3Stream},
    MavlinkOffer{GpsRawInt::kId, 1, kStatusStream},
    MavlinkOffer{Attitude::kId, 50, kExtra1Stream},
    MavlinkOffer{AttitudeQuaternion::kId, 0, 0},
    MavlinkOffer{LocalPositionNed::kId, 30, kPositionStream},
    MavlinkOffer{GlobalPositionInt::kId, 10, kPositionStream},
    MavlinkOffer{MissionCurrent::kId, 0.2, kStatusStream},
    MavlinkOffer{GpsGlobalOrigin::kId, 0, 0},
    MavlinkOffer{RcChannels::kId, 0, kRcStream},
    MavlinkOffer{VfrHud::kId, 4, kExtra2Stream},
    MavlinkOffer{BatteryStatus::kId, 0.5, kExtra3Stream},
    MavlinkOffer{AutopilotVersion::kId, 0, 0},
    MavlinkOffer{HomePosition::kId, 0.5, 0},
    MavlinkOffer{ExtendedSysState::kId, 1, 0},
};

float Float(double value) { return static_cast<float>(value); }
template <class T>
T Whole(double value) {
  constexpr double min = std::numeric_limits<T>::min(), max = std::numeric_limits<T>::max();
  return static_cast<T>(std::clamp(std::round(value), min, max));
}

std::uint64_t BootMs(const control::VehicleState& state) {
  return static_cast<std::uint64_t>(std::max(0.0, 1e3 * state.t_s));
}

struct Place {
  std::int32_t latitude, longitude, altitude_mm;
};
Place PlaceOf(const GeodeticOrigin& origin, const Eigen::Vector3d& p_N) {
  const GeodeticPosition place = GeodeticOf(origin, p_N);
  return {Whole<std::int32_t>(1e7 * place.latitude_deg), Whole<std::int32_t>(1e7 * place.longitude_deg),
          Whole<std::int32_t>(1e3 * place.altitude_m)};
}

double Course_deg(double angle) {
  const double deg = Degrees(angle);
  return deg < 0 ? deg + 360 : deg;
}
std::uint16_t Centidegrees(double angle) {
  return static_cast<std::uint16_t>(std::lround(1e2 * Course_deg(angle)) % 36000);
}

GlobalPositionInt GlobalPosition(const MavlinkTold& told, std::uint32_t ms, double yaw) {
  const control::VehicleState& state = told.state;
  const Place place = PlaceOf(told.origin, state.p_NB);
  return {.time_boot_ms = ms,
          .lat = place.latitude,
          .lon = place.longitude,
          .alt = place.altitude_mm,
          .relative_alt = Whole<std::int32_t>(1e3 * (told.home_N.z() - state.p_NB.z())),
          .vx = Whole<std::int16_t>(1e2 * state.v_N.x()),
          .vy = Whole<std::int16_t>(1e2 * state.v_N.y()),
          .vz = Whole<std::int16_t>(1e2 * state.v_N.z()),
          .hdg = Centidegrees(yaw)};
}

GpsRawInt Gps(const MavlinkTold& told) {
  constexpr std::uint8_t kFix3d = 3;
  const control::VehicleState& state = told.state;
  const Place place = PlaceOf(told.origin, state.p_NB);
  const double speed = state.v_N.head<2>().norm();
  return {.time_usec = 1000 * BootMs(state),
          .lat = place.latitude,
          .lon = place.longitude,
          .alt = place.altitude_mm,
          .eph = kUnknown16,
          .epv = kUnknown16,
          .vel = Whole<std::uint16_t>(1e2 * speed),
          .cog = Centidegrees(std::atan2(state.v_N.y(), state.v_N.x())),
          .fix_type = kFix3d,
          .satellites_visible = kUnknown8};
}

HomePosition Home(const MavlinkTold& told) {
  const Place place = PlaceOf(told.origin, told.home_N);
  return {.latitude = place.latitude,
          .longitude = place.longitude,
          .altitude = place.altitude_mm,
          .x = Float(told.home_N.x()),
          .y = Float(told.home_N.y()),
          .z = Float(told.home_N.z()),
          .q = {1, 0, 0, 0},
          .time_usec = 1000 * BootMs(told.state)};
}

RcChannels Channels(const MavlinkTold& told, std::uint32_t ms) {
  RcChannels channels{.time_boot_ms = ms, .rssi = 254};
  channels.chan_raw.fill(kUnused_us);
  channels.chancount = static_cast<std::uint8_t>(std::max(8, told.switch_channel));
  std::fill_n(channels.chan_raw.begin(), channels.chancount, kCentre_us);
  channels.chan_raw[static_cast<std::size_t>(told.switch_channel - 1)] =
      told.pilot_allows ? kSwitchOn_us : kSwitchOff_us;
  return channels;
}

std::uint8_t LandedState(const MavlinkTold& told) {
  if (told.state.mode == FlightMode::kStopped) return kOnGround;
  if (told.state.mode == FlightMode::kTakeOff) return kTakingOff;
  return told.doing == MavlinkDoing::kLand ? kLanding : kInAir;
}

// Nothing of it is known.
BatteryStatus Battery() {
  BatteryStatus battery{.current_consumed = -1,
                        .energy_consumed = -1,
                        .temperature = std::numeric_limits<std::int16_t>::max(),
                        .current_battery = -1,
                        .battery_remaining = -1};
  battery.voltages.fill(kUnknown16);
  return battery;
}

AutopilotVersion Version(const MavlinkTold& told) {
  const bool px4 = &told.dialect == &kPx4;
  return {.capabilities = kAble | (px4 ? kParamBytes : kParamCast),
          .uid = static_cast<std::uint64_t>(told.system),
          .flight_sw_version = px4 ? Release(1, 15, 0) : Release(4, 6, 0)};
}

}  // namespace

std::span<const MavlinkOffer> MavlinkOffers() { return kOffers; }

std::optional<Message> Tell(std::uint32_t id, const MavlinkTold& told) {
  const control::VehicleState& state = told.state;
  const auto ms = static_cast<std::uint32_t>(BootMs(state));
  const TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  const Eigen::Vector3f p = state.p_NB.cast<float>(), v = state.v_N.cast<float>(),
                        w = state.w_B.cast<float>();
  switch (id) {
    case SysStatus::kId:
      return SysStatus{.onboard_control_sensors_present = kParts,
                       .onboard_control_sensors_enabled = kParts,
                       .onboard_control_sensors_health = kParts,
                       .voltage_battery = kUnknown16,
                       .current_battery = -1,
                       .battery_remaining = -1};
    case SystemTime::kId:
      return SystemTime{static_cast<std::uint64_t>(std::llround(1e6 * told.unix_s)), ms};
    case GpsRawInt::kId:
      return Gps(told);
    case Attitude::kId:
      return Attitude{ms, Float(angles.roll), Float(angles.pitch), Float(angles.yaw), w.x(), w.y(), w.z()};
    case AttitudeQuaternion::kId: {
      const Eigen::Quaternionf q = state.R_NB.normalized().cast<float>();
      return AttitudeQuaternion{.time_boot_ms = ms,
                                .q1 = q.w(),
                                .q2 = q.x(),
                                .q3 = q.y(),
                                .q4 = q.z(),
                                .rollspeed = w.x(),
                                .pitchspeed = w.y(),
                                .yawspeed = w.z()};
    }
    case LocalPositionNed::kId:
      return LocalPositionNed{ms, p.x(), p.y(), p.z(), v.x(), v.y(), v.z()};
    case GlobalPositionInt::kId:
      return GlobalPosition(told, ms, angles.yaw);
    case MissionCurrent::kId:
      return MissionCurrent{.mission_state = kNoMission};
    case GpsGlobalOrigin::kId: {
      const Place place = PlaceOf(told.origin, Eigen::Vector3d::Zero());
      return GpsGlobalOrigin{place.latitude, place.longitude, place.altitude_mm, 1000 * BootMs(state)};
    }
    case RcChannels::kId:
      return Channels(told, ms);
    case VfrHud::kId: {
      const double ground_speed = state.v_N.head<2>().norm();
      return VfrHud{.airspeed = Float(ground_speed),  // it has no other
                    .groundspeed = Float(ground_speed),
                    .alt = Float(told.origin.altitude_m - state.p_NB.z()),
                    .climb = -v.z(),
                    .heading = static_cast<std::int16_t>(std::lround(Course_deg(angles.yaw)) % 360)};
    }
    case BatteryStatus::kId:
      return Battery();
    case AutopilotVersion::kId:
      return Version(told);
    case HomePosition::kId:
      return Home(told);
    case ExtendedSysState::kId:
      return ExtendedSysState{.landed_state = LandedState(told)};
    default:
      return std::nullopt;
  }
}

}  // namespace kestrel::sim
