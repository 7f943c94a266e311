// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "control/wire/asctec_units.h"
#include "tests/sim/server/asctec_line.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

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

}  // namespace
}  // namespace kestrel::control
