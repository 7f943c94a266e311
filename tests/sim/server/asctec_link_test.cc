// SPDX-License-Identifier: Apache-2.0
#include "control/link/asctec_link.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>
#include <vector>

#include "control/wire/asctec_units.h"
#include "geometry/tait_bryan.h"
#include "sim/autopilot/emulated_autopilot.h"
#include "sim/server/asctec_server.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "sim/world/wind.h"
#include "tests/sim/pelican_over_a_plane.h"
#include "tests/sim/perfect_sensors.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kTick_s = 0.002;

// Says what it is told to and keeps what it hears.
class ScriptedAircraft final : public Autopilot {
 public:
  ScriptedAircraft() {
    state.landed = false;
    state.mode = FlightMode::kHold;
  }
  VehicleState State() const override { return state; }
  void Send(const Setpoint& setpoint) override { heard.push_back(setpoint); }
  void Aid(const AttitudeAid&) override { ++aids; }

  VehicleState state;
  std::vector<Setpoint> heard;
  int aids = 0;
};

// Both ends and the line between them, in a time of its own.
struct Line {
  explicit Line(const AscTecOptions& options = {}, const sim::AscTecProcessorOptions& far = {})
      : session(options), processor(far) {
    session.Opened(t_s);
  }
  void Run(
      double duration_s, Autopilot& aircraft, const std::function<void()>& each = [] {}) {
    for (const double end = t_s + duration_s - kTick_s / 2; t_s < end;) {
      t_s += kTick_s;
      wire::Bytes asked = session.Say(t_s);
      if (to_processor) to_processor(asked);
      bytes_asked += asked.size();
      processor.Receive(t_s, asked);
      wire::Bytes said = processor.Step(t_s, aircraft);
      if (to_session) to_session(said);
      bytes_said += said.size();
      session.Receive(t_s, said);
      each();
    }
  }
  // With the setpoint kept up at 20 Hz.
  void Keep(
      const Setpoint& setpoint, double duration_s, Autopilot& aircraft,
      const std::function<void()>& each = [] {}) {
    double due_s = t_s;
    Run(duration_s, aircraft, [&] {
      if (t_s >= due_s) session.Send(t_s, setpoint), due_s += 0.05;
      each();
    });
  }

  double t_s = 100;
  AscTecSession session;
  sim::AscTecProcessor processor;
  std::function<void(wire::Bytes&)> to_processor, to_session;
  std::size_t bytes_asked = 0, bytes_said = 0;
};

VehicleState SomeState() {
  VehicleState s;
  s.landed = false;
  s.p_NB = {12.3, -45.6, -7.8};
  s.v_N = {1.234, -0.567, 0.321};
  s.R_NB = RotationFromTaitBryan({-2.1, 0.15, -0.22});
  s.w_B = {0.3, -0.2, 0.7};
  return s;
}

TEST(AscTecSession, StateNumbersArriveRight) {
  for (const char* signs : {"asctec", "ros"}) {
    AscTecOptions options;
    options.signs = signs;
    sim::AscTecProcessorOptions far;
    far.signs = signs;
    far.origin = {-33.9, 179.9999, 20};  // the date line lies within
    Line line(options, far);
    ScriptedAircraft aircraft;
    line.Run(0.3, aircraft);  // from the first fix and height on
    EXPECT_TRUE(line.session.State().p_NB.isZero());
    aircraft.state = SomeState();
    line.Run(0.3, aircraft);
    const VehicleState heard = line.session.State();
    const VehicleState& said = aircraft.state;
    EXPECT_LT((heard.v_N - said.v_N).cwiseAbs().maxCoeff(), 0.0006);
    // 1e-7 degrees are 11 mm; and the place is carried back by its speed to when the attitude was, 18 ms
    // before
    EXPECT_LT((heard.p_NB - said.p_NB).norm(), 0.012 + 0.018 * said.v_N.norm());
    EXPECT_LT(heard.R_NB.angularDistance(said.R_NB), 3e-5);
    EXPECT_LT((heard.w_B - said.w_B).cwiseAbs().maxCoeff(), 0.5001 * wire::kRad_sPerRateCount);
    EXPECT_FALSE(heard.landed);
    aircraft.state.landed = true;
    line.Run(0.3, aircraft);
    EXPECT_TRUE(line.session.State().landed);
    EXPECT_EQ(line.session.State().mode, FlightMode::kStopped);
    EXPECT_EQ(line.session.Health(line.t_s).error, "");
  }
}

TEST(AscTecSession, RollIsWhereTheDriversDisagree) {
  sim::AscTecProcessorOptions far;
  far.signs = "ros";
  Line line({}, far);
  ScriptedAircraft aircraft;
  aircraft.state.R_NB = RotationFromTaitBryan({0.5, 0.1, 0.2});
  line.Run(0.3, aircraft);
  const TaitBryan heard = TaitBryanFromRotation(line.session.State().R_NB.toRotationMatrix());
  EXPECT_NEAR(heard.roll, -0.2, 1e-4);
  EXPECT_NEAR(heard.pitch, 0.1, 1e-4);
  EXPECT_NEAR(heard.yaw, 0.5, 1e-4);
}

TEST(AscTecSession, StatesComeAtTheirPaceWithTheTimeAtWhichTheyWereTaken) {
  Line line;
  ScriptedAircraft aircraft;
  line.Run(1, aircraft);
  int states = 0;
  double last_s = line.session.State().t_s, oldest_s = 0, worst_stamp_s = 0;
  const double begun_s = line.t_s;
  const std::size_t said_before = line.bytes_said;
  line.Run(4, aircraft, [&] {
    // It turns as time goes by, so that each attitude tells when it was taken.
    aircraft.state.R_NB = RotationFromTaitBryan({0.2 * (line.t_s - begun_s), 0, 0});
    const VehicleState heard = line.session.State();
    if (heard.t_s == last_s) return;
    ++states;
    last_s = heard.t_s;
    oldest_s = std::max(oldest_s, line.t_s - heard.t_s);
    if (states > 2)
      worst_stamp_s = std::max(worst_stamp_s, std::abs(heard.t_s - begun_s - YawOf(heard.R_NB) / 0.2));
  });
  EXPECT_GE(states, 4 * 24);
  EXPECT_LE(states, 4 * 25 + 1);
  EXPECT_LT(oldest_s, 0.045);
  EXPECT_LT(worst_stamp_s, 2.5 * kTick_s);  // looked at each tick, at both ends
  EXPECT_EQ(line.session.cycles_lost(), 0u);
  const double on_the_line_s = wire::LineTime_s(line.bytes_said - said_before);
  EXPECT_LT(on_the_line_s, 4);
  EXPECT_GT(on_the_line_s, 3);
}

TEST(AscTecProcessor, BytesLeaveAtThePaceOfTheLine) {
  sim::AscTecProcessor processor({});
  ScriptedAircraft aircraft;
  const wire::Bytes ask = Encode(wire::Command(wire::Request{wire::kRequestBits}));
  processor.Receive(10, ask);
  const std::size_t frames = 16 + 28 + 92 + 34 + 16 + 44 + 60 + 7 * wire::kTelemetryOverhead;
  std::size_t said = 0;
  wire::TelemetryParser parser;
  std::size_t messages = 0;
  for (double t_s = 10; t_s < 10.2; t_s += 0.001) {
    const wire::Bytes bytes = processor.Step(t_s, aircraft);
    said += bytes.size();
    messages += parser.Feed(bytes).size();
    if (said > 0) {
      EXPECT_LE(wire::LineTime_s(said + ask.size()), t_s - 10 + 1e-9);
    }
    if (said < frames) {
      EXPECT_GT(wire::LineTime_s(said + ask.size()), t_s - 10 - 0.002);  // nor slower
    }
  }
  EXPECT_EQ(said, frames);
  EXPECT_EQ(messages, 7u);  // once each
}

template <class S>
S LastOf(const ScriptedAircraft& aircraft) {
  if (aircraft.heard.empty() || !std::holds_alternative<S>(aircraft.heard.back())) {
    ADD_FAILURE() << "no such setpoint";
    return {};
  }
  return std::get<S>(aircraft.heard.back());
}

// A peer that writes faster than the line is, as no real one can: the line holds a buffer of it and no more.
TEST(AscTecProcessor, OfAFloodTheLineHoldsTheNewestBytes) {
  sim::SerialLine line;
  std::vector<std::uint8_t> block(256);
  for (int i = 0; i < 4000; ++i) {
    std::fill(block.begin(), block.end(), static_cast<std::uint8_t>(i % 251));
    line.Put(0, block);
  }
  const wire::Bytes arrived = line.Receive(1e9);
  ASSERT_EQ(arrived.size(), sim::SerialLine::kMax);
  EXPECT_EQ(arrived.back(), 3999 % 251);
  EXPECT_EQ(arrived.front(), (4000 - sim::SerialLine::kMax / 256) % 251);
  line.Put(2e9, block);  // and it goes on as before
  EXPECT_EQ(line.Receive(3e9).size(), block.size());
}

TEST(AscTecSession, AttitudesArriveRight) {
  for (const char* signs : {"asctec", "ros"}) {
    AscTecOptions options;
    options.signs = signs;
    sim::AscTecProcessorOptions far;
    far.signs = signs;
    Line line(options, far);
    ScriptedAircraft aircraft;
    line.Run(0.3, aircraft);
    EXPECT_TRUE(aircraft.heard.empty());
    line.Keep(AttitudeSetpoint{0.12, -0.23, 0.8, 0.61}, 0.4, aircraft);
    const auto heard = LastOf<AttitudeSetpoint>(aircraft);
    EXPECT_NEAR(heard.roll, 0.12, 0.5001 * wire::kFullTilt_rad / 2047);
    EXPECT_NEAR(heard.pitch, -0.23, 0.5001 * wire::kFullTilt_rad / 2047);
    EXPECT_NEAR(heard.yaw_rate, 0.8, 0.5001 * wire::kFullYawRate_rad_s / 2047);
    EXPECT_NEAR(heard.thrust, 0.61, 0.5001 / 4095);
    EXPECT_GE(aircraft.heard.size(), 8u);  // one each cycle
    EXPECT_EQ(line.session.State().mode, FlightMode::kAttitude);
    EXPECT_EQ(line.session.Health(line.t_s).sent, aircraft.heard.size());
    EXPECT_EQ(line.session.unacknowledged(), 0u);
  }
}

TEST(AscTecSession, ANewSetpointDoesNotWaitForTheNextState) {
  Line line;
  ScriptedAircraft aircraft;
  line.Run(0.5, aircraft);
  line.Keep(VelocitySetpoint{}, 0.5, aircraft);
  for (int i = 1; i <= 40; ++i) {
    line.Run(0.05 + 0.001 * i, aircraft);
    line.session.Send(line.t_s, AttitudeSetpoint{0.01 * i, 0, 0, 0.5});
    const double sent_s = line.t_s;
    double there_s = 0;
    line.Run(0.03, aircraft, [&] {
      const auto* heard = std::get_if<AttitudeSetpoint>(&aircraft.heard.back());
      if (there_s == 0 && std::abs(heard->roll - 0.01 * i) < 1e-3) there_s = line.t_s;
    });
    ASSERT_GT(there_s, 0) << i;
    EXPECT_LT(there_s - sent_s, 0.01 + wire::LineTime_s(17 + 6) + 3 * kTick_s);
  }
  // However fast they come, the line has room.
  const std::uint64_t sent = line.session.Health(line.t_s).sent;
  line.Run(1, aircraft, [&] { line.session.Send(line.t_s, VelocitySetpoint{}); });
  EXPECT_LT(line.session.Health(line.t_s).sent - sent, 130u);
  EXPECT_LT(*line.session.Health(line.t_s).state_age_s, 0.06);
}

// By the manual's units and the names of the fields alone, without the help of the other end.
TEST(AscTecSession, CountsMeanWhatTheManualSays) {
  AscTecSession session({});
  session.Opened(10);
  const auto answer = [&](double t_s, const wire::ImuCalcData& imu, std::int32_t north, std::int32_t east) {
    (void)session.Say(t_s);
    wire::GpsDataAdvanced gps;
    gps.gps.status = 0x03;
    gps.latitude_best_estimate = 480000000 + north, gps.longitude_best_estimate = 110000000 + east;
    gps.speed_x_best_estimate = 700, gps.speed_y_best_estimate = -300;  // east, north
    wire::LlStatus status;
    status.flying = status.motors_on = 1;
    status.flightMode = 0x21, status.battery_voltage_1 = 11100;
    wire::RcData rc;
    rc.channels_in[4] = 4095;
    for (const wire::Telemetry& message :
         {wire::Telemetry(status), wire::Telemetry(imu), wire::Telemetry(rc), wire::Telemetry(gps)})
      session.Receive(t_s, Encode(message));
    return session.Say(t_s + 0.002);
  };
  wire::ImuCalcData imu;
  imu.height = 52000;
  (void)answer(10, imu, 0, 0);
  imu.angle_roll = 10000, imu.angle_nick = 5000, imu.angle_yaw = 270000;  // right, nose down, west
  imu.angvel_yaw = 648;                                                   // 10 degrees a second
  imu.height = 53500, imu.dheight = 250;
  (void)answer(10.05, imu, 1000, 1000);
  const VehicleState heard = session.State();
  const TaitBryan angles = TaitBryanFromRotation(heard.R_NB.toRotationMatrix());
  EXPECT_NEAR(Degrees(angles.roll), 10, 1e-9);
  EXPECT_NEAR(Degrees(angles.pitch), -5, 1e-9);
  EXPECT_NEAR(Degrees(angles.yaw), -90, 1e-9);
  EXPECT_NEAR(Degrees(heard.w_B.z()), 10, 1e-9);
  EXPECT_LT((heard.v_N - Vector3d(-0.3, 0.7, -0.25)).norm(), 1e-9);
  EXPECT_NEAR(heard.p_NB.z(), -1.5, 1e-9);
  // A degree at 48 degrees north: 111.2 km of latitude, 74.6 km of longitude.
  EXPECT_NEAR(heard.p_NB.x(), 11.12, 0.02);
  EXPECT_NEAR(heard.p_NB.y(), 7.46, 0.02);

  session.Send(10.1, AttitudeSetpoint{Radians(10), Radians(-5), Radians(12), 0.5});
  const wire::Bytes bytes = answer(10.1, imu, 1000, 1000);
  wire::CommandParser parser;
  const auto commands = parser.Feed(bytes);
  ASSERT_FALSE(commands.empty());
  const auto* input = std::get_if<wire::CtrlInput>(&commands[0]);
  ASSERT_TRUE(input);
  EXPECT_EQ(input->roll, 400);   // 1000 counts for 25 degrees, to the right
  EXPECT_EQ(input->pitch, 200);  // nose down is forward
  EXPECT_EQ(input->yaw, 100);    // 1000 counts for 120 degrees a second
  EXPECT_EQ(input->thrust, 2048);
  EXPECT_EQ(input->ctrl, 0x0F);
}

TEST(AscTecSession, VelocitiesArriveRightInTheGpsMode) {
  AscTecOptions options;
  options.mode = "gps";
  Line line(options);
  ScriptedAircraft aircraft;
  line.Run(0.3, aircraft);
  line.Keep(VelocitySetpoint{{1.1, -0.6, 0.4}, -0.5}, 0.4, aircraft);
  const auto heard = LastOf<VelocitySetpoint>(aircraft);
  EXPECT_LT((heard.v_H - Vector3d(1.1, -0.6, 0.4)).cwiseAbs().maxCoeff(), 0.5001 * 3 / 2047);
  EXPECT_NEAR(heard.yaw_rate, -0.5, 0.5001 * wire::kFullYawRate_rad_s / 2047);
  EXPECT_EQ(line.session.State().mode, FlightMode::kVelocity);
  // A processor that does not know those bits takes the same for an attitude.
  sim::AscTecProcessorOptions far;
  far.gps_mode = false;
  Line other(options, far);
  ScriptedAircraft leaning;
  other.Run(0.3, leaning);
  other.Keep(VelocitySetpoint{{1.1, -0.6, 0.4}, -0.5}, 0.4, leaning);
  EXPECT_LT(LastOf<AttitudeSetpoint>(leaning).pitch, -0.2);
}

TEST(AscTecSession, MotorsThatDoNotStartAreTrouble) {
  Line line;
  ScriptedAircraft aircraft;
  aircraft.state.landed = true;
  line.Run(0.3, aircraft);
  line.to_processor = [parser = std::make_shared<wire::CommandParser>()](wire::Bytes& bytes) {
    wire::Bytes kept;  // the sticks do not get through
    for (const wire::Command& command : parser->Feed(bytes)) {
      if (!std::holds_alternative<wire::Request>(command)) continue;
      for (const std::uint8_t byte : Encode(command)) kept.push_back(byte);
    }
    bytes = kept;
  };
  line.Keep(PositionSetpoint{{0, 0, -2}, 0}, 5, aircraft);
  EXPECT_NE(line.session.Health(line.t_s).error.find("motors"), std::string::npos);
  const std::uint64_t sent = line.session.Health(line.t_s).sent;
  line.Keep(PositionSetpoint{{0, 0, -2}, 0}, 1, aircraft);
  EXPECT_EQ(line.session.Health(line.t_s).sent, sent);  // and they are left alone
}

TEST(AscTecSession, RatesCannotBeSaidAndEndWhatWasAskedForBefore) {
  Line line;
  ScriptedAircraft aircraft;
  line.Run(0.3, aircraft);
  line.Keep(AttitudeSetpoint{0, 0, 0, 0.5}, 0.2, aircraft);
  const std::size_t heard = aircraft.heard.size();
  ASSERT_GT(heard, 0u);
  line.session.Send(line.t_s, RateSetpoint{{0, 0, 0}, 0.5});
  EXPECT_NE(line.session.Health(line.t_s).error.find("RateSetpoint"), std::string::npos);
  line.Run(0.3, aircraft);
  EXPECT_LE(aircraft.heard.size(), heard + 1);  // one may have been on the line
}

TEST(AscTecSession, FallsSilentWhenSetpointsCease) {
  Line line;
  ScriptedAircraft aircraft;
  line.Run(0.3, aircraft);
  line.session.Send(line.t_s, AttitudeSetpoint{0, 0, 0, 0.5});
  const double sent_s = line.t_s;
  double last_s = 0;
  std::size_t heard = 0;
  line.Run(1, aircraft, [&] {
    if (aircraft.heard.size() > heard) last_s = line.t_s, heard = aircraft.heard.size();
  });
  EXPECT_GE(heard, 4u);
  EXPECT_GT(last_s - sent_s, AutopilotLink::kRepeat_s - 0.05);
  EXPECT_LT(last_s - sent_s, AutopilotLink::kRepeat_s + 0.01);  // and 3 ms on the line
  line.Keep(AttitudeSetpoint{0, 0, 0, 0.5}, 0.2, aircraft);
  line.session.Silence();
  line.Run(0.01, aircraft);
  heard = aircraft.heard.size();
  line.Run(1, aircraft);
  EXPECT_EQ(aircraft.heard.size(), heard);
  EXPECT_LT(*line.session.Health(line.t_s).state_age_s, 0.05);  // the state goes on
}

TEST(AscTecSession, ThePilotsSwitchKeepsSetpointsOff) {
  Line line;
  ScriptedAircraft aircraft;
  EXPECT_FALSE(line.session.Health(line.t_s).pilot_allows);
  line.Run(0.3, aircraft);
  EXPECT_EQ(line.session.Health(line.t_s).pilot_allows, true);
  line.Keep(VelocitySetpoint{}, 0.5, aircraft);
  EXPECT_FALSE(aircraft.heard.empty());
  line.processor.SetPilot(false);
  line.Keep(VelocitySetpoint{}, 0.3, aircraft);
  EXPECT_EQ(line.session.Health(line.t_s).pilot_allows, false);
  const std::size_t heard = aircraft.heard.size();
  const std::uint64_t sent = line.session.Health(line.t_s).sent;
  line.Keep(VelocitySetpoint{}, 0.5, aircraft);
  EXPECT_EQ(aircraft.heard.size(), heard);
  EXPECT_EQ(line.session.Health(line.t_s).sent, sent);
  line.processor.SetPilot(true);
  line.Keep(VelocitySetpoint{}, 0.4, aircraft);
  EXPECT_GT(aircraft.heard.size(), heard);
}

TEST(AscTecSession, ErrorsHaveNames) {
  const auto error = [](const Line& line) { return line.session.Health(line.t_s).error; };
  ScriptedAircraft aircraft;
  sim::AscTecProcessorOptions far;
  far.battery_v = 10.1;
  Line weak({}, far);
  weak.Run(0.3, aircraft);
  EXPECT_EQ(error(weak), "the battery has 10.1 V, less than 10.4 V");

  Line line;
  line.Run(0.3, aircraft);
  EXPECT_EQ(error(line), "");
  line.session.Send(line.t_s, VelocitySetpoint{{NAN, 0, 0}, 0});
  EXPECT_NE(error(line), "");
  line.Run(0.1, aircraft);
  EXPECT_TRUE(aircraft.heard.empty());
  line.session.Send(line.t_s, VelocitySetpoint{});
  EXPECT_EQ(error(line), "");
  line.session.Aid();
  EXPECT_NE(error(line).find("attitude"), std::string::npos);
  EXPECT_EQ(aircraft.aids, 0);

  Line cut;
  cut.Run(0.3, aircraft);
  cut.to_session = [](wire::Bytes& bytes) { bytes.clear(); };
  cut.Keep(VelocitySetpoint{}, 0.6, aircraft);
  EXPECT_EQ(error(cut), "the processor does not answer");
  EXPECT_GT(*cut.session.Health(cut.t_s).state_age_s, 0.5);
  const std::uint64_t sent = cut.session.Health(cut.t_s).sent;
  cut.Keep(VelocitySetpoint{}, 1, aircraft);  // nothing is flown by an old state
  EXPECT_EQ(cut.session.Health(cut.t_s).sent, sent);
  cut.to_session = nullptr;
  cut.Keep(VelocitySetpoint{}, 0.5, aircraft);
  EXPECT_EQ(error(cut), "");
  EXPECT_GT(cut.session.Health(cut.t_s).sent, sent);
}

// What a frame says that the emulated processor never would.
TEST(AscTecSession, HeedsEmergencyAndALostFixAndMissingAcknowledgements) {
  const auto error = [](const Line& line) { return line.session.Health(line.t_s).error; };
  const auto replaced = [](auto change) {
    return [change, parser = std::make_shared<wire::TelemetryParser>()](wire::Bytes& bytes) {
      wire::Bytes changed;
      for (wire::Telemetry message : parser->Feed(bytes)) {
        if (!change(message)) continue;
        for (const std::uint8_t byte : Encode(message)) changed.push_back(byte);
      }
      bytes = changed;
    };
  };
  ScriptedAircraft aircraft;
  Line lost;
  lost.to_session = replaced([](wire::Telemetry& message) {
    if (auto* status = std::get_if<wire::LlStatus>(&message))
      status->flightMode |= wire::kFlightModeEmergency;
    return true;
  });
  lost.Keep(VelocitySetpoint{}, 0.5, aircraft);
  EXPECT_EQ(error(lost), "emergency: the processor has lost its R/C");
  EXPECT_EQ(lost.session.Health(lost.t_s).pilot_allows, false);
  EXPECT_TRUE(aircraft.heard.empty());

  Line blind;
  blind.to_session = replaced([](wire::Telemetry& message) {
    if (auto* gps = std::get_if<wire::GpsDataAdvanced>(&message)) gps->gps.status = 0;
    return true;
  });
  blind.Keep(VelocitySetpoint{}, 0.5, aircraft);
  EXPECT_EQ(error(blind), "no GPS fix");
  EXPECT_FALSE(blind.session.Health(blind.t_s).state_age_s);
  EXPECT_TRUE(aircraft.heard.empty());

  Line late;
  late.Keep(VelocitySetpoint{}, 0.5, aircraft);
  const double good_s = late.t_s - *late.session.Health(late.t_s).state_age_s;
  late.to_session = replaced(
      [](wire::Telemetry& message) { return !std::holds_alternative<wire::GpsDataAdvanced>(message); });
  late.Keep(VelocitySetpoint{}, 0.4, aircraft);
  EXPECT_NEAR(*late.session.Health(late.t_s).state_age_s, late.t_s - good_s, 0.05);

  Line deaf;
  deaf.to_session = replaced(
      [](wire::Telemetry& message) { return !std::holds_alternative<wire::Acknowledgement>(message); });
  deaf.Keep(VelocitySetpoint{}, 1, aircraft);
  EXPECT_EQ(error(deaf), "setpoints are not acknowledged");
  EXPECT_GT(deaf.session.unacknowledged(), 10u);
}

TEST(AscTecSession, DamagedBytesCostWhatTheyHitAndNoMore) {
  Line line;
  ScriptedAircraft aircraft;
  aircraft.state = SomeState();
  line.Run(0.5, aircraft);
  std::mt19937_64 numbers(7);
  const auto damage = [&](wire::Bytes& bytes) {
    for (auto& byte : bytes)
      if (numbers() % 400 == 0) byte = static_cast<std::uint8_t>(numbers());
  };
  line.to_processor = line.to_session = damage;
  int states = 0;
  double last_s = line.session.State().t_s, oldest_s = 0;
  const AttitudeSetpoint asked{0.1, -0.05, 0.2, 0.5};
  aircraft.heard.clear();
  line.Keep(asked, 20, aircraft, [&] {
    const VehicleState heard = line.session.State();
    oldest_s = std::max(oldest_s, line.t_s - heard.t_s);
    if (heard.t_s == last_s) return;
    ++states, last_s = heard.t_s;
    ASSERT_LT(heard.R_NB.angularDistance(aircraft.state.R_NB), 1e-3);
    ASSERT_LT((heard.v_N - aircraft.state.v_N).norm(), 0.002);
    ASSERT_FALSE(heard.landed);
  });
  for (const Setpoint& setpoint : aircraft.heard) {
    ASSERT_NEAR(std::get<AttitudeSetpoint>(setpoint).roll, 0.1, 1e-3);
    ASSERT_NEAR(std::get<AttitudeSetpoint>(setpoint).thrust, 0.5, 1e-3);
  }
  EXPECT_GT(line.session.Health(line.t_s).refused, 50u);
  EXPECT_EQ(line.processor.received().followed, aircraft.heard.size());
  EXPECT_GT(line.processor.received().ignored.at(sim::ignored::kDamaged).count, 0u);
  EXPECT_GT(states, 200);  // of 500
  EXPECT_GT(aircraft.heard.size(), 250u);
  EXPECT_LT(oldest_s, 0.6);
  line.to_processor = line.to_session = nullptr;
  const std::uint64_t lost = line.session.cycles_lost();
  line.Run(0.2, aircraft);
  const std::uint64_t settled = line.session.cycles_lost();
  EXPECT_LE(settled, lost + 1);
  line.Run(1, aircraft);
  EXPECT_EQ(line.session.cycles_lost(), settled);
}

// An aircraft with its emulated autopilot, in air.
class Pelican final : public Autopilot {
 public:
  Pelican(const Pose& X_NB, bool flying, const sim::WindParameters& wind,
          const sim::SensorParameters& sensors, std::uint64_t seed)
      : model_(sim::PelicanOverAPlane()),
        data_(mj_makeData(model_.get())),
        vehicle_({}, model_.get()),
        wind_(wind, seed),
        sensors_(sensors, seed),
        autopilot_({}, sensors, sim::MultirotorParameters{}, X_NB, flying, Vector3d::Zero()) {
    sim::PoseToMujoco(X_NB, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }
  VehicleState State() const override { return autopilot_.State(); }
  void Send(const Setpoint& setpoint) override { autopilot_.Send(setpoint); }
  void Aid(const AttitudeAid& aid) override { autopilot_.Aid(aid); }

  void Step() {
    const Vector3d before = v_N();
    wind_.Step(kTick_s, -X_NB().p.z(), before);
    vehicle_.Apply(data_.get(), kTick_s, wind_.Velocity(), 0);
    mj_step(model_.get(), data_.get());
    const Vector3d force_B = X_NB().R.conjugate() * ((v_N() - before) / kTick_s - Vector3d(0, 0, 9.80665));
    const Vector3d w_B = sim::VectorFromMujoco(data_->qvel + 3);
    vehicle_.Command(std::get<sim::RotorSpeeds>(
        autopilot_.Step(kTick_s, sensors_.Read(kTick_s, X_NB(), v_N(), w_B, force_B))));
  }
  Pose X_NB() const { return sim::PoseFromMujoco(data_->qpos); }
  Vector3d v_N() const { return sim::VectorFromMujoco(data_->qvel); }

 private:
  sim::ModelPtr model_;
  sim::DataPtr data_;
  sim::Multirotor vehicle_;
  sim::Wind wind_;
  sim::Sensors sensors_;
  sim::EmulatedAutopilot autopilot_;
};

void FliesVelocitiesAndPlaces(const std::string& mode, FlightMode aircrafts) {
  sim::WindParameters wind;
  wind.mean_m_s = 4, wind.from_deg = 200;
  Pelican pelican({HeadingRotation(0.6), {0, 0, -10}}, true, wind, sim::PerfectSensors(), 1);
  AscTecOptions options;
  options.mode = mode;
  Line line(options);
  const auto step = [&] { pelican.Step(); };
  line.Run(1, pelican, step);
  const Vector3d start = pelican.X_NB().p;
  line.Keep(VelocitySetpoint{{1, 0.5, -0.3}, 0}, 12, pelican, step);
  EXPECT_EQ(pelican.State().mode, aircrafts);
  const Vector3d wanted = HeadingRotation(YawOf(pelican.X_NB().R)) * Vector3d(1, 0.5, -0.3);
  EXPECT_LT((pelican.v_N() - wanted).norm(), 0.1);
  EXPECT_NEAR(YawOf(pelican.X_NB().R), 0.6, 0.05);
  // N of the link begins where the aircraft was first heard of.
  line.Keep(PositionSetpoint{{3, -2, -1}, -0.5}, 25, pelican, step);
  EXPECT_LT((pelican.X_NB().p - start - Vector3d(3, -2, -1)).norm(), 0.3);
  EXPECT_NEAR(YawOf(pelican.X_NB().R), -0.5, 0.05);
}

TEST(AscTecFlight, VelocitiesAndPlacesAreFlownByAttitude) {
  FliesVelocitiesAndPlaces("attitude", FlightMode::kAttitude);
}
TEST(AscTecFlight, VelocitiesAndPlacesAreFlownInTheGpsMode) {
  FliesVelocitiesAndPlaces("gps", FlightMode::kVelocity);
}

TEST(AscTecFlight, TakesOffAndLandsByAttitudeInWindWithRealSensors) {
  for (const std::uint64_t seed : {1, 2}) {
    sim::WindParameters wind;
    wind.mean_m_s = 3, wind.from_deg = 240, wind.turbulence = true, wind.gusts = {6, 2, 3};
    Pelican pelican({HeadingRotation(0.3), {0, 0, -0.16}}, false, wind, {}, seed);
    Line line;
    const auto step = [&] { pelican.Step(); };
    line.Run(1, pelican, step);
    ASSERT_TRUE(line.session.State().landed);
    line.Keep(VelocitySetpoint{{0, 0, -1}, 0}, 1, pelican, step);
    EXPECT_EQ(pelican.State().mode, FlightMode::kStopped);  // only a position takes off
    line.Keep(PositionSetpoint{{0, 0, -2}, 0.3}, 10, pelican, step);
    EXPECT_NEAR(-pelican.X_NB().p.z(), 2.16, 0.6) << seed;
    EXPECT_EQ(line.session.Health(line.t_s).error, "");
    bool landed_in_the_air = false;
    double stopped_s = -1, touched_s = -1;
    const auto watch = [&] {
      pelican.Step();
      const bool up = pelican.X_NB().p.z() < -0.25;
      if (!up && touched_s < 0) touched_s = line.t_s;
      landed_in_the_air |= up && line.session.State().landed;
      if (stopped_s < 0 && line.session.State().landed) stopped_s = line.t_s;
    };
    for (int i = 0; i < 50 && stopped_s < 0; ++i)
      line.Keep(VelocitySetpoint{{0, 0, 0.25}, 0}, 0.5, pelican, watch);
    EXPECT_FALSE(landed_in_the_air) << seed;
    ASSERT_GT(stopped_s, 0) << seed;
    EXPECT_LT(stopped_s - touched_s, 4) << seed;
    EXPECT_TRUE(pelican.State().landed);
    EXPECT_EQ(line.session.Health(line.t_s).error, "");
  }
}

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Serves until something is so; in real time.
template <class Condition>
bool ServeUntil(sim::AscTecServer* server, Autopilot& aircraft, const Condition& condition) {
  for (const double end_s = Now_s() + 20; Now_s() < end_s;) {
    if (server) server->Serve(Now_s(), aircraft);
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}
std::string DeviceOf(const sim::AscTecServer& server) {
  return server.Where().substr(std::strlen("serial:"));
}

TEST(AscTecLink, HearsAndIsHeardOverAPseudoTerminal) {
  sim::AscTecServer server({});
  AscTecOptions options;
  options.device = DeviceOf(server);
  AscTecLink link(options);
  ScriptedAircraft aircraft;
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] { return link.Health().pilot_allows == true; }));
  aircraft.state = SomeState();
  ASSERT_TRUE(ServeUntil(&server, aircraft,
                         [&] { return link.State().R_NB.angularDistance(aircraft.state.R_NB) < 1e-3; }));
  EXPECT_TRUE(link.Health().open);
  EXPECT_GT(link.State().t_s, Now_s() - 5);
  EXPECT_LT(link.State().t_s, Now_s());
  link.Aid({});
  EXPECT_EQ(aircraft.aids, 0);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    link.Send(AttitudeSetpoint{0.1, 0.2, 0.3, 0.4});
    return aircraft.heard.size() >= 3;
  }));
  EXPECT_NEAR(LastOf<AttitudeSetpoint>(aircraft).thrust, 0.4, 1e-3);
  EXPECT_GE(link.Health().sent, 3u);
  EXPECT_EQ(server.counts().Refused(wire::LinkRefusal::kCheckSum), 0u);
}

TEST(AscTecLink, TwoDoNotCommandOneDevice) {
  sim::AscTecServer server({});
  AscTecOptions options;
  options.device = DeviceOf(server);
  ScriptedAircraft aircraft;
  auto first = std::make_unique<AscTecLink>(options);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] { return first->Health().pilot_allows == true; }));
  AscTecLink second(options);
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    second.Send(AttitudeSetpoint{0, 0, 0, 1});
    return second.Health().error == options.device + ": in use by another program";
  }));
  // The first is not disturbed, and the second has said nothing.
  const std::uint64_t received = first->Health().received;
  ASSERT_TRUE(ServeUntil(&server, aircraft, [&] {
    second.Send(AttitudeSetpoint{0, 0, 0, 1});
    return first->Health().received > received + 10;
  }));
  EXPECT_EQ(second.Health().received, 0u);
  EXPECT_TRUE(aircraft.heard.empty());
  first.reset();
  EXPECT_TRUE(ServeUntil(&server, aircraft, [&] { return second.Health().open; }));
}

TEST(AscTecLink, OpensTheDeviceAgainWhenTheFarEndComesBack) {
  const auto folder = std::filesystem::temp_directory_path() / ("kestrel_asctec_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto device = folder / "tty";
  AscTecOptions options;
  options.device = device;
  AscTecLink link(options);
  ScriptedAircraft aircraft;
  EXPECT_TRUE(ServeUntil(nullptr, aircraft, [&] {
    return !link.Health().open && link.Health().error.find(device) != std::string::npos;
  }));
  std::uint64_t received = 0;
  for (int time = 0; time < 2; ++time) {
    sim::AscTecServer server({});
    std::filesystem::create_symlink(DeviceOf(server), device);
    EXPECT_TRUE(ServeUntil(&server, aircraft, [&] { return link.Health().received > received + 5; }));
    EXPECT_TRUE(link.Health().open);
    received = link.Health().received;
    std::filesystem::remove(device);
  }
  EXPECT_TRUE(ServeUntil(nullptr, aircraft, [&] { return !link.Health().open; }));
  EXPECT_NE(link.Health().error, "");
  EXPECT_TRUE(link.Health().state_age_s);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kestrel::control
