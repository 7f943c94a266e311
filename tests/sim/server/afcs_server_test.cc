// SPDX-License-Identifier: Apache-2.0
#include "sim/server/afcs_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/diagnostics.h"
#include "control/link/afcs_link.h"
#include "geometry/tait_bryan.h"
#include "tests/control/udp_peer.h"

namespace kestrel::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// An aircraft that stays as the test has it and keeps what it is told.
class FakeAircraft final : public control::Autopilot {
 public:
  FakeAircraft() {
    state.t_s = 50;
    state.p_NB = {1, 2, -3}, state.v_N = {4, 5, -6}, state.w_B = {0.3, 0.4, 0.5};
    state.R_NB = RotationFromTaitBryan({.yaw = 2.5, .pitch = -0.2, .roll = 0.1});
    state.landed = false;
  }
  control::VehicleState State() const override { return state; }
  void Send(const control::Setpoint& setpoint) override { told.push_back(setpoint); }
  void Aid(const control::AttitudeAid&) override {}

  control::VehicleState state;
  std::vector<control::Setpoint> told;
};

AfcsServerOptions AnyPort() {
  AfcsServerOptions options;
  options.port = 0;
  return options;
}
int PortOf(const AutopilotServer& server) {
  const std::string where = server.Where();
  return std::stoi(where.substr(where.rfind(':') + 1));
}

// The server under test at times that the test makes, and peers that say what the test says.
class AfcsServerTest : public ::testing::Test {
 protected:
  void Start(const AfcsServerOptions& options, PanTilt* platform = nullptr) {
    server_.emplace(options, platform);
    peer_.To(control::UdpPeer::Loopback(PortOf(*server_)));
    stranger_.To(control::UdpPeer::Loopback(PortOf(*server_)));
  }
  // Serves for some time, and gathers what the peer is sent.
  void Serve(double for_s = 0) {
    const double until_s = now_s_ + for_s;
    do {
      server_->Serve(now_s_, aircraft_);
      Gather();
      now_s_ += 0.005, aircraft_.state.t_s += 0.005;
    } while (now_s_ < until_s);
  }
  void Gather() {
    while (const auto datagram = peer_.Receive()) heard_.push_back(*datagram);
  }
  void Say(const control::wire::AfcsMessage& message, double for_s = 0) {
    stamp_.microseconds += 1;
    peer_.Send(stamp_, message);
    Serve(for_s);
  }
  template <class Message>
  std::vector<Message> Heard() {
    std::vector<Message> all;
    for (const auto& datagram : heard_)
      if (const auto* message = std::get_if<Message>(&datagram.message)) all.push_back(*message);
    return all;
  }

  FakeAircraft aircraft_;
  std::optional<AfcsServer> server_;
  control::UdpPeer peer_, stranger_;
  double now_s_ = 1000;
  control::wire::AfcsTime stamp_{7, 0};
  std::vector<control::wire::AfcsDatagram> heard_;
};

TEST_F(AfcsServerTest, ListensOnLoopbackAndSaysWhere) {
  Start(AnyPort());
  EXPECT_THAT(server_->Where(), StartsWith("udp://127.0.0.1:"));
  AfcsServerOptions everywhere = AnyPort();
  everywhere.address = "0.0.0.0";
  EXPECT_THAT(AfcsServer(everywhere).Where(), StartsWith("udp://0.0.0.0:"));
}

TEST_F(AfcsServerTest, RefusesAnAddressThatItCannotHave) {
  Start(AnyPort());
  AfcsServerOptions taken = AnyPort();
  taken.port = PortOf(*server_);
  EXPECT_THROW(AfcsServer{taken}, InputError);
  AfcsServerOptions none = AnyPort();
  none.address = "here";
  EXPECT_THROW(AfcsServer{none}, InputError);
}

TEST_F(AfcsServerTest, SaysNothingBeforeItIsOpened) {
  Start(AnyPort());
  Say(control::wire::AfcsTeleop{1, 0, 0, 0}, 0.1);
  EXPECT_TRUE(heard_.empty());
  EXPECT_TRUE(aircraft_.told.empty());
  EXPECT_EQ(server_->Received().ignored.at(ignored::kNoSession).count, 1U);
  EXPECT_EQ(server_->Received().setpoints, 0U);
}

TEST_F(AfcsServerTest, AcknowledgesEveryOpen) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsOpen{});
  EXPECT_EQ(Heard<control::wire::AfcsAck>(), (std::vector<control::wire::AfcsAck>{{1}, {1}}));
}

TEST_F(AfcsServerTest, SendsStatesAt50HzAndGpsAt4Hz) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{}, 2);
  EXPECT_NEAR(static_cast<double>(Heard<control::wire::AfcsState>().size()), 100, 1);
  EXPECT_NEAR(static_cast<double>(Heard<control::wire::AfcsGpsState>().size()), 8, 1);
}

TEST_F(AfcsServerTest, DoesNotMakeUpForStatesThatWereMissed) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  now_s_ += 1;  // nobody served
  heard_.clear();
  Serve(0.1);
  EXPECT_NEAR(static_cast<double>(Heard<control::wire::AfcsState>().size()), 5, 1);
}

TEST_F(AfcsServerTest, TheStateIsTheAircraftsWithItsTime) {
  Start(AnyPort());
  const control::VehicleState& s = aircraft_.state;
  const double sent_s = s.t_s;
  Say(control::wire::AfcsOpen{});
  ASSERT_EQ(Heard<control::wire::AfcsState>().size(), 1U);
  const control::wire::AfcsState m = Heard<control::wire::AfcsState>()[0];
  EXPECT_NEAR(m.phi, 0.1, 1e-12);
  EXPECT_NEAR(m.theta, -0.2, 1e-12);
  EXPECT_NEAR(m.psi, 2.5, 1e-12);
  EXPECT_EQ(Eigen::Vector3d(m.p, m.q, m.r), s.w_B);
  EXPECT_EQ(Eigen::Vector3d(m.x, m.y, m.z), s.p_NB);
  EXPECT_EQ(Eigen::Vector3d(m.vx, m.vy, m.vz), s.v_N);
  EXPECT_EQ(m.rpm0, 1500);
  for (const auto& datagram : heard_) EXPECT_NEAR(control::wire::Seconds(datagram.time), sent_s, 5e-6);
  aircraft_.state.landed = true;
  heard_.clear();
  Serve(0.03);
  EXPECT_EQ(Heard<control::wire::AfcsState>().at(0).rpm0, 0);
}

TEST_F(AfcsServerTest, GpsTellsThePlaceOnTheEarth) {
  AfcsServerOptions options = AnyPort();
  options.origin = GeodeticOrigin{40, -3, 600};
  Start(options);
  aircraft_.state.p_NB = {1000, -2000, -50};
  Say(control::wire::AfcsOpen{});
  const control::wire::AfcsGpsState m = Heard<control::wire::AfcsGpsState>().at(0);
  EXPECT_EQ(m.pos_n, 1000);
  EXPECT_EQ(m.vel_d, -6);
  // A degree at 40 degrees of latitude: 111034.6 m north and 85393.6 m east on the ellipsoid (tables of
  // WGS 84), and 600 m higher longer by 600 m per radian.
  EXPECT_NEAR(m.lat, 40 + 1000 / (111034.6 + Radians(600)), 1e-7);
  EXPECT_NEAR(m.lon, -3 - 2000 / (85393.6 + Radians(600 * std::cos(Radians(40)))), 1e-7);
  EXPECT_EQ(m.alt, 650);
}

TEST_F(AfcsServerTest, WithoutAnOriginGpsTellsRawPlacesAsAfcs25Does) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  const control::wire::AfcsGpsState m = Heard<control::wire::AfcsGpsState>().at(0);
  EXPECT_EQ(Eigen::Vector3d(m.lat, m.lon, m.alt), aircraft_.state.p_NB);
}

TEST_F(AfcsServerTest, TeleoperationIsAVelocityLessOffsetAndDeadZone) {
  AfcsServerOptions options = AnyPort();
  options.afcs.teleop = {{0.20, 0.05}, {-0.10, 0.02}, {0.30, 0.10}, {0.04, 0.01}, true};
  Start(options);
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsTeleop{0.05, -0.5, 1.0, 0.1});
  ASSERT_EQ(aircraft_.told.size(), 1U);
  const auto velocity = std::get<control::VelocitySetpoint>(aircraft_.told[0]);
  EXPECT_LT((velocity.v_H - Eigen::Vector3d(-0.10, -0.38, -0.60)).norm(), 1e-12);  // fore: backwards
  EXPECT_NEAR(velocity.yaw_rate, 0.05, 1e-12);
}

TEST_F(AfcsServerTest, FlyToIsAPlaceAndConfirmed) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsFlyTo{0, 0, 0, 1, 2, -3, 0.5});
  ASSERT_EQ(aircraft_.told.size(), 1U);
  const auto place = std::get<control::PositionSetpoint>(aircraft_.told[0]);
  EXPECT_EQ(place.p_N, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(place.yaw, 0.5);
  EXPECT_EQ(Heard<control::wire::AfcsDesiredPosition>(),
            (std::vector<control::wire::AfcsDesiredPosition>{{1, 2, -3, 0.5}}));
  Say(control::wire::AfcsFlyTo{1, 0, 0, 1, 2, -3, 0.5});  // a mode that it does not have
  EXPECT_EQ(aircraft_.told.size(), 1U);
  EXPECT_EQ(Heard<control::wire::AfcsDesiredPosition>().size(), 1U);
}

TEST_F(AfcsServerTest, DoesNotObeyWhatNoAircraftCould) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsTeleop{std::nan(""), 0, 0, 0});
  Say(control::wire::AfcsTeleop{0, 1e300, 0, 0});
  Say(control::wire::AfcsFlyTo{.z = std::numeric_limits<double>::infinity()});
  Say(control::wire::AfcsFlyTo{.pos_mode = 77});
  EXPECT_TRUE(aircraft_.told.empty());
  EXPECT_EQ(server_->Received().setpoints, 0U);
  EXPECT_EQ(server_->Received().refused, 4U);
  ASSERT_TRUE(server_->Received().ignored.contains(ignored::kImpossible));
  EXPECT_EQ(server_->Received().ignored.at(ignored::kImpossible).count, 4U);
  EXPECT_THAT(server_->Received().ignored.at(ignored::kImpossible).first, HasSubstr("TELEOP nan"));
  EXPECT_TRUE(Heard<control::wire::AfcsDesiredPosition>().empty());
}

TEST_F(AfcsServerTest, ThePilotsSwitchEndsObedience) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  server_->SetPilot(false);
  Say(control::wire::AfcsTeleop{1, 0, 0, 0});
  Say(control::wire::AfcsFlyTo{});
  EXPECT_TRUE(aircraft_.told.empty());
  EXPECT_TRUE(Heard<control::wire::AfcsDesiredPosition>().empty());
  server_->SetPilot(true);
  Say(control::wire::AfcsTeleop{1, 0, 0, 0});
  EXPECT_EQ(aircraft_.told.size(), 1U);
  EXPECT_EQ(server_->Received().setpoints, 3U);
  EXPECT_EQ(server_->Received().followed, 1U);
  EXPECT_EQ(server_->Received().ignored.at(ignored::kPilot).count, 2U);
}

TEST_F(AfcsServerTest, AStrangerIsNeitherObeyedNorAnsweredNorMayHeTakeOver) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  for (const control::wire::AfcsMessage& message :
       {control::wire::AfcsMessage{control::wire::AfcsOpen{}},
        control::wire::AfcsMessage{control::wire::AfcsTeleop{1, 0, 0, 0}},
        control::wire::AfcsMessage{control::wire::AfcsFlyTo{}},
        control::wire::AfcsMessage{control::wire::AfcsClose{}}}) {
    stamp_.microseconds += 1;
    stranger_.Send(stamp_, message);
  }
  heard_.clear();
  Serve(0.1);
  EXPECT_TRUE(aircraft_.told.empty());
  EXPECT_FALSE(stranger_.Receive());
  EXPECT_EQ(server_->Received().ignored.at(ignored::kSecondClient).count, 1U);
  EXPECT_EQ(server_->Received().ignored.at(ignored::kNoSession).count, 3U);
  EXPECT_THAT(server_->Received().ignored.at(ignored::kSecondClient).first,
              HasSubstr("; it is that of 127."));
  EXPECT_NEAR(static_cast<double>(Heard<control::wire::AfcsState>().size()), 5, 1);
  Say(control::wire::AfcsTeleop{1, 0, 0, 0});
  EXPECT_EQ(aircraft_.told.size(), 1U);
}

TEST_F(AfcsServerTest, ClosedByItsOwnerAnotherMayOpen) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsClose{});
  EXPECT_EQ(Heard<control::wire::AfcsClose>().size(), 1U);
  heard_.clear();
  Serve(0.1);
  EXPECT_TRUE(heard_.empty());
  stranger_.Send({1, 0}, control::wire::AfcsOpen{});
  Serve();
  ASSERT_TRUE(stranger_.Receive());
}

TEST_F(AfcsServerTest, AnOwnerWhoIsSilentIsForgotten) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{}, 2.9);
  EXPECT_GT(Heard<control::wire::AfcsState>().size(), 140U);
  Say(control::wire::AfcsOpen{}, 2.9);  // which keeps the session
  heard_.clear();
  Serve(0.09);
  EXPECT_FALSE(heard_.empty());
  Serve(0.1);
  heard_.clear();
  Serve(1);
  EXPECT_TRUE(heard_.empty());
  Say(control::wire::AfcsTeleop{1, 0, 0, 0});
  EXPECT_TRUE(aircraft_.told.empty());
}

TEST_F(AfcsServerTest, AFloodNeitherHidesTheOwnerNorTakesTheSession) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 1000; ++k) {  // more than a queue holds
      stamp_.microseconds += 1;
      stranger_.Send(stamp_, k % 2 == 0 ? control::wire::AfcsMessage{control::wire::AfcsOpen{}}
                                        : control::wire::AfcsMessage{control::wire::AfcsTeleop{9, 0, 0, 0}});
    }
    Say(control::wire::AfcsTeleop{1, 0, 0, 0});
    ASSERT_EQ(aircraft_.told.size(), i + 1U);
    EXPECT_EQ(std::get<control::VelocitySetpoint>(aircraft_.told.back()).v_H.x(), 1);
    now_s_ += 1;
  }
}

TEST_F(AfcsServerTest, WhoSpokeInTimeAndWasReadLateKeepsTheSession) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  now_s_ += 100;
  stranger_.Send({8, 0}, control::wire::AfcsOpen{});
  Say(control::wire::AfcsTeleop{1, 0, 0, 0});
  EXPECT_EQ(aircraft_.told.size(), 1U);
  EXPECT_FALSE(stranger_.Receive());
  now_s_ += AnyPort().session_s + 0.1;
  stranger_.Send({9, 0}, control::wire::AfcsOpen{});
  Serve();
  EXPECT_TRUE(stranger_.Receive());  // he was silent
}

TEST_F(AfcsServerTest, DoubledAndLateCommandsAreNotObeyed) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  peer_.Send({8, 5}, control::wire::AfcsTeleop{1, 0, 0, 0});
  peer_.Send({8, 5}, control::wire::AfcsTeleop{2, 0, 0, 0});
  peer_.Send({8, 4}, control::wire::AfcsTeleop{3, 0, 0, 0});
  peer_.Send({1, 2, 3});
  peer_.Send({8, 6}, control::wire::AfcsTeleop{4, 0, 0, 0});
  Serve();
  ASSERT_EQ(aircraft_.told.size(), 2U);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(aircraft_.told[0]).v_H.x(), 1);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(aircraft_.told[1]).v_H.x(), 4);
  EXPECT_EQ(server_->Received().setpoints, 2U);
  EXPECT_EQ(server_->Received().ignored.at(ignored::kAgain).count, 2U);
  EXPECT_EQ(server_->Received().ignored.at(ignored::kDamaged).count, 1U);
}

TEST_F(AfcsServerTest, WithoutAPlatformNoneAnswers) {
  Start(AnyPort());
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsPlatform{});
  EXPECT_TRUE(Heard<control::wire::AfcsPlatform>().empty());
}

TEST_F(AfcsServerTest, ThePlatformTurnsAndAnswersWithEveryField) {
  PanTilt platform({}, Eigen::Vector3d::Zero(), {});
  Start(AnyPort(), &platform);
  aircraft_.state.R_NB = HeadingRotation(0.5);
  aircraft_.state.p_NB = {10, 20, -30};
  Say(control::wire::AfcsOpen{});
  Say(control::wire::AfcsPlatform{.mode = 0, .relative_pitch = -Radians(45), .relative_yaw = 0.2});
  for (int i = 0; i < 1000; ++i) platform.Step(0.01, {aircraft_.state.R_NB, aircraft_.state.p_NB});
  Say(control::wire::AfcsPlatform{.mode = 0, .relative_pitch = -Radians(45), .relative_yaw = 0.2});
  ASSERT_EQ(Heard<control::wire::AfcsPlatform>().size(), 2U);
  const auto before = Heard<control::wire::AfcsPlatform>()[0],
             after = Heard<control::wire::AfcsPlatform>()[1];
  EXPECT_EQ(before.relative_yaw, 0);         // where it is, not where it is to be
  EXPECT_TRUE(std::isnan(before.camera_n));  // level: nowhere on the ground
  EXPECT_NEAR(after.relative_yaw, 0.2, 1e-12);
  EXPECT_NEAR(after.relative_pitch, -Radians(45), 1e-12);
  EXPECT_NEAR(after.absolute_yaw, 0.7, 1e-12);
  EXPECT_NEAR(after.absolute_pitch, -Radians(45), 1e-12);
  EXPECT_NEAR(after.absolute_roll, 0, 1e-12);
  EXPECT_NEAR(after.camera_n, 10 + 30 * std::cos(0.7), 1e-9);  // as far ahead as it is high
  EXPECT_NEAR(after.camera_e, 20 + 30 * std::sin(0.7), 1e-9);
  EXPECT_NEAR(after.camera_d, 0, 1e-9);
}

TEST_F(AfcsServerTest, ThePlatformLooksAtAPlace) {
  PanTilt platform({}, Eigen::Vector3d::Zero(), {});
  Start(AnyPort(), &platform);
  aircraft_.state.R_NB = HeadingRotation(0), aircraft_.state.p_NB = {0, 0, -10};
  Say(control::wire::AfcsOpen{});
  const control::wire::AfcsPlatform look{.mode = 2, .camera_n = 10, .camera_e = 0, .camera_d = 0};
  Say(look);
  for (int i = 0; i < 1000; ++i) platform.Step(0.01, {aircraft_.state.R_NB, aircraft_.state.p_NB});
  Say(look);
  EXPECT_NEAR(Heard<control::wire::AfcsPlatform>().at(1).relative_pitch, -Radians(45), 1e-9);
  Say(control::wire::AfcsPlatform{.mode = 9});  // a mode that it does not have
  EXPECT_EQ(Heard<control::wire::AfcsPlatform>().size(), 2U);
}

// ------------------------------------------------------------------------------ both ends of the wire

class AfcsWire : public ::testing::Test {
 protected:
  AfcsWire() {
    server_options_.port = 0;
    link_options_.open_s = 0.02, link_options_.alive_s = 0.1, link_options_.silent_s = 30;
  }
  void StartServer() {
    server_.emplace(server_options_);
    server_options_.port = link_options_.port = PortOf(*server_);
  }
  bool ServedUntil(const std::function<bool()>& holds) {
    return control::Eventually([&] {
      const double now_s = control::MonotonicTestNow_s();
      aircraft_.state.t_s = now_s - began_s_;
      if (server_) server_->Serve(now_s, aircraft_);
      return holds();
    });
  }

  FakeAircraft aircraft_;
  AfcsServerOptions server_options_;
  control::AfcsLinkOptions link_options_;
  std::optional<AfcsServer> server_;
  double began_s_ = control::MonotonicTestNow_s();
};

TEST_F(AfcsWire, TheStateArrivesWithItsNumbersAndItsTime) {
  StartServer();
  control::AfcsLink link(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return link.Health().received > 20; }));
  const control::VehicleState state = link.State();
  EXPECT_EQ(state.p_NB, aircraft_.state.p_NB);
  EXPECT_EQ(state.v_N, aircraft_.state.v_N);
  EXPECT_EQ(state.w_B, aircraft_.state.w_B);
  EXPECT_LT(state.R_NB.angularDistance(aircraft_.state.R_NB), 1e-7);
  EXPECT_FALSE(state.landed);
  const double true_s = control::MonotonicTestNow_s();  // the aircraft's clock began at began_s_
  EXPECT_LE(state.t_s, true_s);
  EXPECT_GE(state.t_s, began_s_);
  EXPECT_TRUE(link.Health().open);
  EXPECT_EQ(link.Health().refused, 0U);
  EXPECT_EQ(link.Health().error, "");
}

TEST_F(AfcsWire, WhatIsAskedForIsWhatTheAircraftIsToldThroughOffsetAndDeadZone) {
  server_options_.afcs.teleop =
      link_options_.afcs.teleop = {{0.20, 0.05}, {-0.10, 0.02}, {0.30, 0.10}, {0.04, 0.01}, true};
  StartServer();
  control::AfcsLink link(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return link.Health().open; }));
  const control::VelocitySetpoint wanted{{0.02, -0.3, 0.1}, -0.2};
  ASSERT_TRUE(ServedUntil([&] {
    link.Send(wanted);
    return !aircraft_.told.empty();
  }));
  const auto told = std::get<control::VelocitySetpoint>(aircraft_.told[0]);
  EXPECT_LT((told.v_H - wanted.v_H).norm(), 1e-12);
  EXPECT_NEAR(told.yaw_rate, wanted.yaw_rate, 1e-12);
}

TEST_F(AfcsWire, APlaceIsToldAndConfirmed) {
  StartServer();
  control::AfcsLink link(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return link.Health().open; }));
  ASSERT_TRUE(ServedUntil([&] {
    link.Send(control::PositionSetpoint{{1, 2, -3}, 0.5});
    return link.Desired().has_value();
  }));
  EXPECT_EQ(std::get<control::PositionSetpoint>(aircraft_.told.at(0)).p_N, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(link.Desired()->yaw, 0.5);
}

TEST_F(AfcsWire, IsOpenedAgainAfterTheServerWasKilledAndStartedAgain) {
  link_options_.silent_s = 0.5;
  StartServer();
  control::AfcsLink link(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return link.Health().received > 5; }));
  server_.reset();
  ASSERT_TRUE(ServedUntil([&] { return !link.Health().open; }));
  EXPECT_GT(*link.Health().state_age_s, 0.5);
  StartServer();
  began_s_ = control::MonotonicTestNow_s();  // its clock begins anew
  aircraft_.state.p_NB = {7, 8, -9};
  ASSERT_TRUE(ServedUntil([&] { return link.Health().open && *link.Health().state_age_s < 0.1; }));
  EXPECT_EQ(link.State().p_NB, Eigen::Vector3d(7, 8, -9));
  EXPECT_GE(link.State().t_s, began_s_);
  EXPECT_TRUE(ServedUntil([&] {
    link.Send(control::VelocitySetpoint{{1, 0, 0}, 0});
    return !aircraft_.told.empty();
  }));
}

TEST_F(AfcsWire, ASecondLinkWaitsUntilTheFirstHasClosed) {
  StartServer();
  auto first = std::make_unique<control::AfcsLink>(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return first->Health().open; }));
  control::AfcsLink second(link_options_);
  ASSERT_TRUE(ServedUntil([&] { return !second.Health().error.empty(); }));
  EXPECT_FALSE(second.Health().open);
  first.reset();
  EXPECT_TRUE(ServedUntil([&] { return second.Health().open; }));
}

}  // namespace
}  // namespace kestrel::sim
