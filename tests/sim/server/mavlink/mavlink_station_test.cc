// SPDX-License-Identifier: Apache-2.0
// An emulated PX4 or ArduPilot before a ground station: what is asked is answered, what is not possible is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "sim/server/mavlink/mavlink_vehicle.h"
#include "tests/control/mavlink_frames.h"
#include "tests/sim/server/fake_aircraft.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;
using control::wire::Bytes;
using ::testing::HasSubstr;

constexpr std::array<const char*, 2> kBoth{"px4", "ardupilot"};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
// MAV_RESULT
constexpr int kAccepted = 0, kDenied = 2, kUnsupported = 3;

FakeAircraft OnTheGround() {
  FakeAircraft aircraft;
  aircraft.state.t_s = 50;
  return aircraft;
}

// A ground station of the system 255 and its aircraft, in simulated time.
struct Station {
  explicit Station(const std::string& dialect, FakeAircraft its = OnTheGround())
      : options{.dialect = dialect}, vehicle(options), aircraft(std::move(its)) {
    Say(Heartbeat{.type = 6, .autopilot = 8});
  }
  // What comes back at once.
  std::vector<Message> Say(const Message& message) {
    vehicle.Receive(sender.Encode(message), now_s, aircraft);
    return Hear();
  }
  std::vector<Message> Hear() {
    std::vector<Message> heard;
    for (const Bytes& datagram : vehicle.Due(now_s, aircraft))
      for (const Frame& frame : Parser(Formats()).Datagram(datagram)) heard.push_back(*Decode(frame));
    return heard;
  }
  std::vector<Message> Run(double duration_s) {
    std::vector<Message> heard;
    for (const double end_s = now_s + duration_s; now_s < end_s;) {
      now_s += 0.02, aircraft.Step(0.02);
      for (const Message& message : Hear()) heard.push_back(message);
    }
    return heard;
  }
  int Command(std::uint16_t command, float p1 = 0, float p7 = 0) {
    return ResultOf(Say(CommandLong{.param1 = p1,
                                    .param4 = kNan,
                                    .param5 = kNan,
                                    .param6 = kNan,
                                    .param7 = p7,
                                    .command = command,
                                    .target_system = 1,
                                    .target_component = 1}),
                    command);
  }
  // Of the acknowledgement, which must be to us; -1: none came.
  static int ResultOf(const std::vector<Message>& heard, int command) {
    int result = -1;
    for (const Message& message : heard)
      if (const auto* ack = std::get_if<CommandAck>(&message); ack && ack->command == command) {
        EXPECT_EQ(ack->target_system, 255);
        EXPECT_EQ(ack->target_component, 190);
        result = ack->result;
      }
    return result;
  }
  template <class M>
  static std::vector<M> All(const std::vector<Message>& heard) {
    std::vector<M> all;
    for (const Message& message : heard)
      if (const auto* m = std::get_if<M>(&message)) all.push_back(*m);
    return all;
  }
  Heartbeat Mode() {
    vehicle.Greet();
    return All<Heartbeat>(Hear()).back();
  }

  MavlinkServerOptions options;
  MavlinkVehicle vehicle;
  FakeAircraft aircraft;
  Sender sender{255, 190};
  double now_s = 1000;
};

std::string TextOf(const std::vector<Message>& heard) {
  std::string all;
  for (const Statustext& text : Station::All<Statustext>(heard)) all += std::string(text.text.data());
  return all;
}
std::string NameOf(const ParamValue& value) {
  return {value.param_id.begin(), std::find(value.param_id.begin(), value.param_id.end(), '\0')};
}

TEST(MavlinkStation, ParametersAreListedReadAndSet) {
  for (const char* dialect : kBoth) {
    Station station(dialect);
    const auto list = Station::All<ParamValue>(station.Say(ParamRequestList{1, 1}));
    ASSERT_GE(list.size(), 5U);
    for (std::size_t i = 0; i < list.size(); ++i) {
      EXPECT_EQ(list[i].param_index, i);
      EXPECT_EQ(list[i].param_count, list.size());
      const auto by_number = Station::All<ParamValue>(
          station.Say(ParamRequestRead{.param_index = static_cast<std::int16_t>(i), .target_system = 1}));
      ASSERT_EQ(by_number.size(), 1U);
      EXPECT_EQ(by_number[0], list[i]);
      const auto by_name = Station::All<ParamValue>(
          station.Say(ParamRequestRead{.param_index = -1, .target_system = 1, .param_id = list[i].param_id}));
      ASSERT_EQ(by_name.size(), 1U);
      EXPECT_EQ(by_name[0], list[i]);
    }
    // Another's are not asked of it.
    EXPECT_TRUE(Station::All<ParamValue>(station.Say(ParamRequestList{2, 1})).empty());
    const auto unknown =
        station.Say(ParamRequestRead{.param_index = -1, .target_system = 1, .param_id = Text<16>("NO_SUCH")});
    EXPECT_TRUE(Station::All<ParamValue>(unknown).empty());
    EXPECT_THAT(TextOf(unknown), HasSubstr("NO_SUCH"));
  }
}

TEST(MavlinkStation, AWholeNumberIsBytesOfPx4AndANumberOfArduPilot) {
  Station px4("px4"), ardupilot("ardupilot");
  const auto read = [](Station& station, const char* name) {
    return Station::All<ParamValue>(station.Say(ParamRequestRead{
                                        .param_index = -1, .target_system = 1, .param_id = Text<16>(name)}))
        .at(0);
  };
  EXPECT_EQ(std::bit_cast<std::int32_t>(read(px4, "MAV_SYS_ID").param_value), 1);
  EXPECT_EQ(read(px4, "MAV_SYS_ID").param_type, 6);
  EXPECT_EQ(read(ardupilot, "SYSID_THISMAV").param_value, 1);
  EXPECT_EQ(read(ardupilot, "SYSID_THISMAV").param_type, 4);
}

TEST(MavlinkStation, WhatIsSetIsFlownByAndWhatCannotBeSetKeepsItsValue) {
  for (const char* dialect : kBoth) {
    const bool px4 = std::string(dialect) == "px4";
    const char* name = px4 ? "MPC_LAND_SPEED" : "LAND_SPEED";
    Station station(dialect, Flying(5));
    const auto set = [&](float value) {
      return station.Say(ParamSet{.param_value = value,
                                  .target_system = 1,
                                  .target_component = 1,
                                  .param_id = Text<16>(name),
                                  .param_type = static_cast<std::uint8_t>(px4 ? 9 : 4)});
    };
    const auto answer = Station::All<ParamValue>(set(px4 ? 1.25F : 125));
    ASSERT_EQ(answer.size(), 1U);
    EXPECT_EQ(NameOf(answer[0]), name);
    EXPECT_EQ(answer[0].param_value, px4 ? 1.25F : 125);
    const auto refused = set(px4 ? 77.0F : 7700);
    EXPECT_EQ(Station::All<ParamValue>(refused).at(0).param_value, px4 ? 1.25F : 125);
    EXPECT_THAT(TextOf(refused), HasSubstr(name));
    const auto nan = set(kNan);
    EXPECT_EQ(Station::All<ParamValue>(nan).at(0).param_value, px4 ? 1.25F : 125);
    EXPECT_EQ(station.Command(21), kAccepted);
    station.Run(0.1);
    EXPECT_EQ(std::get<control::VelocitySetpoint>(station.aircraft.sent.back()).v_H.z(), 1.25);
  }
}

TEST(MavlinkStation, WhatFollowsWhenSetpointsStopIsPx4sParameter) {
  const std::vector<std::pair<std::int32_t, std::uint32_t>> modes{{3, 5}, {4, 6}, {5, 3}};
  for (const auto& [act, sub] : modes) {
    Station station("px4", Flying(5));
    station.Say(ParamSet{.param_value = std::bit_cast<float>(act),
                         .target_system = 1,
                         .param_id = Text<16>("COM_OBL_RC_ACT"),
                         .param_type = 6});
    station.Say(ParamSet{
        .param_value = 2, .target_system = 1, .param_id = Text<16>("COM_OF_LOSS_T"), .param_type = 9});
    const Message forward = ToMessage(control::VelocitySetpoint{{0.5, 0, 0}, 0}, 0, kPx4, {}, 0);
    for (int i = 0; i < 15; ++i) station.Say(forward), station.Run(0.1);
    station.Say(SetCustomMode(kPx4.setpoint_mode, kPx4, {}));
    station.Say(forward);
    station.Run(1.8);
    EXPECT_EQ(station.Mode().custom_mode, kPx4.setpoint_mode);
    station.Run(0.4);
    EXPECT_EQ(station.Mode().custom_mode, 4U << 16 | sub << 24);
  }
}

TEST(MavlinkStation, MissionsAreEmptyAndRefused) {
  for (const char* dialect : kBoth) {
    Station station(dialect);
    for (const std::uint8_t type : {0, 1, 2}) {
      const auto count = Station::All<MissionCount>(
          station.Say(MissionRequestList{.target_system = 1, .target_component = 1, .mission_type = type}));
      ASSERT_EQ(count.size(), 1U);
      EXPECT_EQ(count[0].count, 0);
      EXPECT_EQ(count[0].mission_type, type);
      EXPECT_EQ(count[0].target_system, 255);
      EXPECT_EQ(count[0].target_component, 190);
      const auto ack = [&](const Message& message) {
        const auto acks = Station::All<MissionAck>(station.Say(message));
        EXPECT_EQ(acks.size(), 1U);
        EXPECT_EQ(acks.empty() ? type : acks[0].mission_type, type);
        return acks.empty() ? -1 : int{acks[0].type};
      };
      EXPECT_EQ(ack(MissionCount{.count = 3, .target_system = 1, .mission_type = type}), 3);
      EXPECT_EQ(ack(MissionCount{.count = 0, .target_system = 1, .mission_type = type}), 0);
      EXPECT_EQ(ack(MissionClearAll{.target_system = 1, .mission_type = type}), 0);
      EXPECT_EQ(ack(MissionRequestInt{.target_system = 1, .mission_type = type}), 13);
      EXPECT_EQ(ack(MissionRequest{.target_system = 1, .mission_type = type}), 13);
    }
    EXPECT_THAT(TextOf(station.Say(MissionSetCurrent{.seq = 1, .target_system = 1})), HasSubstr("mission"));
    EXPECT_EQ(station.Command(300), kDenied);
  }
}

TEST(MavlinkStation, WhatIsAskedForOnceIsTold) {
  for (const char* dialect : kBoth) {
    const bool px4 = std::string(dialect) == "px4";
    Station station(dialect);
    const auto once = [&](std::uint16_t command, float p1) {
      return station.Say(
          CommandLong{.param1 = p1, .command = command, .target_system = 1, .target_component = 1});
    };
    for (const auto& heard : {once(512, 148), once(520, 1)}) {
      const auto version = Station::All<AutopilotVersion>(heard);
      ASSERT_EQ(version.size(), 1U);
      EXPECT_EQ(version[0].capabilities, 0x20E8U - 0x20 + (px4 ? 0x10U : 0x20000U));
      EXPECT_EQ(version[0].flight_sw_version >> 24, px4 ? 1U : 4U);
    }
    EXPECT_EQ(Station::ResultOf(once(520, 1), 520), kAccepted);
    for (const auto& heard : {once(410, 0), once(512, 242)}) {
      const auto home = Station::All<HomePosition>(heard);
      ASSERT_EQ(home.size(), 1U);
      EXPECT_EQ(home[0].latitude, 404168000);
      EXPECT_EQ(home[0].longitude, -37038000);
      EXPECT_EQ(home[0].altitude, 657000);
    }
    EXPECT_EQ(Station::ResultOf(once(512, 147), 512), kAccepted);
    EXPECT_EQ(Station::All<BatteryStatus>(once(512, 147)).at(0).battery_remaining, -1);
    EXPECT_EQ(Station::ResultOf(once(512, 259), 512), kUnsupported);
    EXPECT_EQ(Station::ResultOf(once(519, 1), 519), kUnsupported);
    EXPECT_EQ(Station::ResultOf(once(31000, 1), 31000), kUnsupported);
    EXPECT_EQ(Station::All<Ping>(station.Say(Ping{.time_usec = 77, .seq = 5})).at(0),
              (Ping{77, 5, 255, 190}));
    EXPECT_TRUE(station.Say(Ping{77, 5, 1, 1}).empty());  // an answer
    const auto sync = Station::All<Timesync>(station.Say(Timesync{.tc1 = 0, .ts1 = 33}));
    ASSERT_EQ(sync.size(), 1U);
    EXPECT_EQ(sync[0].ts1, 33);
    EXPECT_NEAR(1e-9 * static_cast<double>(sync[0].tc1), station.aircraft.state.t_s, 1e-6);
  }
}

TEST(MavlinkStation, EveryMessageComesAtTheIntervalThatIsSet) {
  for (const char* dialect : kBoth) {
    Station station(dialect);
    for (const std::uint32_t id : {1, 2, 24, 30, 31, 32, 33, 42, 65, 74, 147, 242, 245}) {
      EXPECT_EQ(
          Station::ResultOf(
              station.Say(CommandLong{
                  .param1 = static_cast<float>(id), .param2 = 100000, .command = 511, .target_system = 1}),
              511),
          kAccepted)
          << id;
      const auto interval = Station::All<MessageInterval>(
          station.Say(CommandLong{.param1 = static_cast<float>(id), .command = 510, .target_system = 1}));
      EXPECT_EQ(interval.at(0).interval_us, 100000);
      std::size_t came = 0;
      for (const Message& message : station.Run(2)) came += Formats()[message.index()].id == id ? 1 : 0;
      EXPECT_NEAR(static_cast<double>(came), 20, 2) << id;
      station.Say(
          CommandLong{.param1 = static_cast<float>(id), .param2 = -1, .command = 511, .target_system = 1});
    }
    EXPECT_EQ(Station::ResultOf(station.Say(CommandLong{
                                    .param1 = 9999, .param2 = 1e5F, .command = 511, .target_system = 1}),
                                511),
              kDenied);
  }
}

TEST(MavlinkStation, StreamsAreAskedForInGroups) {
  Station station("ardupilot");
  EXPECT_EQ(station.Run(1).size(), Station::All<Heartbeat>(station.Run(1)).size());
  station.Say(
      RequestDataStream{.req_message_rate = 4, .target_system = 1, .req_stream_id = 0, .start_stop = 1});
  const auto all = station.Run(2);
  EXPECT_NEAR(static_cast<double>(Station::All<Attitude>(all).size()), 8, 1);
  EXPECT_NEAR(static_cast<double>(Station::All<GpsRawInt>(all).size()), 8, 1);
  EXPECT_NEAR(static_cast<double>(Station::All<VfrHud>(all).size()), 8, 1);
  station.Say(
      RequestDataStream{.req_message_rate = 4, .target_system = 1, .req_stream_id = 10, .start_stop = 0});
  const auto less = station.Run(2);
  EXPECT_TRUE(Station::All<Attitude>(less).empty());
  EXPECT_NEAR(static_cast<double>(Station::All<GpsRawInt>(less).size()), 8, 1);
}

// As pymavlink names them: of PX4 by base_mode too.
TEST(MavlinkStation, ModesHaveTheFlagsByWhichTheyAreNamed) {
  Station px4("px4", Flying(5));
  constexpr int kAutoFlags = 4 | 8 | 16, kManualInput = 64;
  EXPECT_EQ(px4.Mode().custom_mode, 4U << 16 | 3U << 24);
  EXPECT_EQ(px4.Mode().base_mode & kAutoFlags, kAutoFlags);
  EXPECT_EQ(px4.Mode().base_mode & kManualInput, 0);
  px4.vehicle.SetPilot(false);
  px4.Run(0.1);
  EXPECT_EQ(px4.Mode().custom_mode, 3U << 16);
  EXPECT_NE(px4.Mode().base_mode & kManualInput, 0);
  Station other("px4", Flying(5));
  for (const std::uint32_t sub : {3U, 5U, 6U}) {
    const auto heard =
        other.Say(SetMode{.custom_mode = 4U << 16 | sub << 24, .target_system = 1, .base_mode = 1});
    EXPECT_EQ(Station::ResultOf(heard, 176), kAccepted);
    EXPECT_EQ(other.Mode().custom_mode, 4U << 16 | sub << 24);
    EXPECT_EQ(other.Mode().base_mode & kAutoFlags, kAutoFlags);
  }
  const auto refused =
      other.Say(SetMode{.custom_mode = 4U << 16 | 4U << 24, .target_system = 1, .base_mode = 1});
  EXPECT_EQ(Station::ResultOf(refused, 176), kDenied);
  EXPECT_THAT(TextOf(refused), HasSubstr("AUTO.MISSION"));

  Station ardupilot("ardupilot", Flying(5));
  for (const std::uint32_t mode : {4U, 17U, 6U, 9U, 5U}) {
    EXPECT_EQ(Station::ResultOf(
                  ardupilot.Say(SetMode{.custom_mode = mode, .target_system = 1, .base_mode = 1}), 11),
              kAccepted);
    EXPECT_EQ(ardupilot.Mode().custom_mode, mode);
    EXPECT_NE(ardupilot.Mode().base_mode & 1, 0);
  }
}

TEST(MavlinkStation, TakesOffAsGroundStationsAsk) {
  // QGroundControl: PX4 is told the height above the sea and armed after; ArduPilot above home.
  Station qgc("px4");
  EXPECT_EQ(qgc.Command(22, 0, 657 + 10), kAccepted);
  EXPECT_EQ(qgc.Command(400, 1), kAccepted);
  qgc.Run(0.1);
  EXPECT_EQ(qgc.Mode().custom_mode, 4U << 16 | 2U << 24);
  qgc.Run(10);
  EXPECT_NEAR(qgc.aircraft.state.p_NB.z(), -10, 0.1);
  EXPECT_EQ(qgc.Mode().custom_mode, 4U << 16 | 3U << 24);

  // MAVProxy's "takeoff 10": below where it stands, above the sea; PX4 climbs to its least height.
  Station mavproxy("px4");
  EXPECT_EQ(mavproxy.Command(400, 1), kAccepted);
  EXPECT_EQ(mavproxy.Command(22, 0, 10), kAccepted);
  mavproxy.Run(10);
  EXPECT_NEAR(mavproxy.aircraft.state.p_NB.z(), -2.5, 0.1);
  // MAVSDK tells no height.
  Station mavsdk("px4");
  EXPECT_EQ(mavsdk.Command(400, 1), kAccepted);
  EXPECT_EQ(mavsdk.Command(22, 0, kNan), kAccepted);
  mavsdk.Run(10);
  EXPECT_NEAR(mavsdk.aircraft.state.p_NB.z(), -2.5, 0.1);

  Station ardupilot("ardupilot");
  EXPECT_NE(ardupilot.Command(22, 0, 10), kAccepted);
  EXPECT_EQ(ardupilot.Command(400, 1), kAccepted);
  EXPECT_NE(ardupilot.Command(22, 0, 10), kAccepted);  // not in GUIDED
  ardupilot.Say(SetMode{.custom_mode = 4, .target_system = 1, .base_mode = 1});
  const auto as_int = [&](std::uint8_t frame) {
    return Station::ResultOf(
        ardupilot.Say(
            CommandInt{.z = 10, .command = 22, .target_system = 1, .target_component = 1, .frame = frame}),
        22);
  };
  EXPECT_EQ(as_int(0), kDenied);
  EXPECT_EQ(as_int(3), kAccepted);
  ardupilot.Run(10);
  EXPECT_NEAR(ardupilot.aircraft.state.p_NB.z(), -10, 0.1);
}

TEST(MavlinkStation, ReturnsHomeAndLandsThere) {
  for (const char* dialect : kBoth) {
    FakeAircraft aircraft = Flying(5);
    aircraft.state.p_NB = {30, -40, -5};
    Station station(dialect, aircraft);
    EXPECT_EQ(station.Command(20), kAccepted);
    double highest_m = 0;
    for (int i = 0; i < 300 && station.aircraft.state.mode != control::FlightMode::kStopped; ++i) {
      station.Run(1);
      highest_m = std::max(highest_m, -station.aircraft.state.p_NB.z());
    }
    EXPECT_TRUE(station.aircraft.state.landed);
    EXPECT_LT(station.aircraft.state.p_NB.head<2>().norm(), 0.6);
    EXPECT_NEAR(highest_m, std::string(dialect) == "px4" ? 60 : 15, 1);
    station.Run(0.1);
    EXPECT_EQ(station.Mode().base_mode & 128, 0);
  }
}

TEST(MavlinkStation, GoesToAPlaceOnTheEarth) {
  for (const char* dialect : kBoth) {
    Station station(dialect, Flying(5));
    if (std::string(dialect) == "ardupilot")
      station.Say(SetMode{.custom_mode = 4, .target_system = 1, .base_mode = 1});
    // By the definition: a second of latitude is 30.844 m there by WGS 84's meridian, here 20 m of it.
    const double metre_lat = 1e7 / 111039.0,
                 metre_lon = 1e7 / (111319.5 * std::cos(40.4168 * M_PI / 180) * 1.0014);
    const CommandInt go{.param4 = kNan,
                        .x = static_cast<std::int32_t>(404168000 + std::lround(20 * metre_lat)),
                        .y = static_cast<std::int32_t>(-37038000 + std::lround(-10 * metre_lon)),
                        .z = 8,
                        .command = 192,
                        .target_system = 1,
                        .target_component = 1,
                        .frame = 6};
    EXPECT_EQ(Station::ResultOf(station.Say(go), 192), kAccepted);
    station.Run(25);
    EXPECT_LT((station.aircraft.state.p_NB - Eigen::Vector3d(20, -10, -8)).norm(), 0.1);
    CommandInt nowhere = go;
    nowhere.x = std::numeric_limits<std::int32_t>::max();
    EXPECT_EQ(Station::ResultOf(station.Say(nowhere), 192), kDenied);
  }
}

TEST(MavlinkStation, TheTimeOfDayIsTold) {
  Station station("px4");
  station.vehicle.SetDate(1.7e9 - station.now_s);
  const auto heard = Station::All<SystemTime>(station.Run(2));
  ASSERT_FALSE(heard.empty());
  EXPECT_NEAR(1e-6 * static_cast<double>(heard[0].time_unix_usec), 1.7e9, 3);
}

}  // namespace
}  // namespace kestrel::sim
