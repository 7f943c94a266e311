// SPDX-License-Identifier: Apache-2.0
#include "control/link/afcs_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"
#include "tests/control/udp_peer.h"

namespace kestrel::control {
namespace {

using ::testing::HasSubstr;

// The link under test, and an autopilot that says what the test says.
class AfcsLinkTest : public ::testing::Test {
 protected:
  AfcsLinkTest() {
    options_.port = far_.port();
    options_.open_s = 0.02, options_.alive_s = 0.05, options_.silent_s = 30;
  }

  // The next message of a type; others before it are passed over.
  template <class Message>
  std::optional<Message> Next() {
    std::optional<Message> found;
    Eventually([&] {
      while (const auto datagram = far_.Receive()) {
        if (const auto* message = std::get_if<Message>(&datagram->message)) {
          stamp_ = datagram->time;
          found = *message;
          return true;
        }
      }
      return false;
    });
    return found;
  }
  void Say(const wire::AfcsMessage& message) {
    far_.Send(clock_, message);
    clock_.microseconds += 20000;
    if (clock_.microseconds >= 1000000) clock_ = {clock_.seconds + 1, clock_.microseconds - 1000000};
  }
  void Open(AfcsLink& link) {
    ASSERT_TRUE(Next<wire::AfcsOpen>());
    Say(wire::AfcsAck{1});
    ASSERT_TRUE(Eventually([&] { return link.Health().open; }));
  }
  // Says states until the link has one more.
  void SayState(AfcsLink& link, const wire::AfcsState& state) {
    const auto before = link.Health().received;
    Say(state);
    ASSERT_TRUE(Eventually([&] { return link.Health().received > before; }));
  }

  UdpPeer far_;
  AfcsLinkOptions options_;
  wire::AfcsTime clock_{100, 0}, stamp_;
};

TEST_F(AfcsLinkTest, SaysOpenUntilItIsAcknowledged) {
  AfcsLink link(options_);
  for (int lost = 0; lost < 3; ++lost) ASSERT_TRUE(Next<wire::AfcsOpen>());
  EXPECT_FALSE(link.Health().open);
  Say(wire::AfcsAck{21});  // of something else
  ASSERT_TRUE(Eventually([&] { return link.Health().received > 0; }));
  EXPECT_FALSE(link.Health().open);
  Say(wire::AfcsAck{1});
  EXPECT_TRUE(Eventually([&] { return link.Health().open; }));
  EXPECT_EQ(link.Health().error, "");
}

TEST_F(AfcsLinkTest, BeforeTheFirstStateItHasNone) {
  AfcsLink link(options_);
  Open(link);
  EXPECT_FALSE(link.Health().state_age_s);
  EXPECT_EQ(link.State().t_s, 0);
  EXPECT_FALSE(link.Health().pilot_allows);
}

TEST_F(AfcsLinkTest, SaysThatNobodyAnswers) {
  AfcsLink link(options_);
  EXPECT_TRUE(Eventually([&] { return link.Health().error.find("does not answer") != std::string::npos; }));
}

TEST_F(AfcsLinkTest, AStateIsThatOfTheMessageOnOurClock) {
  AfcsLink link(options_);
  Open(link);
  const double before_s = MonotonicTestNow_s();
  SayState(link, {.phi = 0.1,
                  .theta = -0.2,
                  .psi = 2.5,
                  .p = 0.3,
                  .q = 0.4,
                  .r = 0.5,
                  .x = 1,
                  .y = 2,
                  .z = -3,
                  .vx = 4,
                  .vy = 5,
                  .vz = -6,
                  .mx = 9,
                  .my = 9,
                  .mz = 9,
                  .ax = 9,
                  .ay = 9,
                  .az = 9,
                  .voltage = 9,
                  .rpm0 = 1500});
  const double after_s = MonotonicTestNow_s();
  const VehicleState state = link.State();
  EXPECT_EQ(state.p_NB, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(state.v_N, Eigen::Vector3d(4, 5, -6));
  EXPECT_EQ(state.w_B, Eigen::Vector3d(0.3, 0.4, 0.5));
  const TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  EXPECT_NEAR(angles.roll, 0.1, 1e-12);
  EXPECT_NEAR(angles.pitch, -0.2, 1e-12);
  EXPECT_NEAR(angles.yaw, 2.5, 1e-12);
  EXPECT_TRUE(state.R_NB_inertial->isApprox(state.R_NB));
  EXPECT_GE(state.t_s, before_s);
  EXPECT_LE(state.t_s, after_s);
  EXPECT_FALSE(state.landed);
  EXPECT_LT(*link.Health().state_age_s, 20.0);
}

TEST_F(AfcsLinkTest, TheTimeBetweenStatesIsThatOfTheirStampsHoweverLateTheSecondIs) {
  AfcsLink link(options_);
  Open(link);
  SayState(link, {.rpm0 = 1500});
  const double first_s = link.State().t_s;
  std::this_thread::sleep_for(std::chrono::milliseconds(60));  // on a line that is slow
  SayState(link, {.x = 1, .rpm0 = 1500});
  EXPECT_NEAR(link.State().t_s - first_s, 0.020, 1e-6);
}

TEST_F(AfcsLinkTest, ARotorThatStandsStillIsAnAircraftThatLanded) {
  AfcsLink link(options_);
  Open(link);
  SayState(link, {.rpm0 = 0});
  EXPECT_TRUE(link.State().landed);
  EXPECT_EQ(link.State().mode, FlightMode::kStopped);
  SayState(link, {.rpm0 = 1500});
  EXPECT_FALSE(link.State().landed);
  EXPECT_EQ(link.State().mode, FlightMode::kHold);
}

TEST_F(AfcsLinkTest, DoubledAndLateStatesAreDroppedAndCounted) {
  AfcsLink link(options_);
  Open(link);
  far_.Send({200, 0}, wire::AfcsState{.x = 1, .rpm0 = 1500});
  far_.Send({200, 0}, wire::AfcsState{.x = 2, .rpm0 = 1500});       // doubled
  far_.Send({199, 999999}, wire::AfcsState{.x = 3, .rpm0 = 1500});  // late
  far_.Send({1, 2, 3});                                             // damaged
  far_.Send({200, 1}, wire::AfcsGpsState{.numsv = 7});
  ASSERT_TRUE(Eventually([&] { return link.Gps().has_value(); }));
  EXPECT_EQ(link.State().p_NB.x(), 1);
  EXPECT_EQ(link.Health().refused, 3U);
  EXPECT_EQ(link.Gps()->numsv, 7);
}

TEST_F(AfcsLinkTest, AStateThatCannotBeIsRefusedAndNamed) {
  AfcsLink link(options_);
  Open(link);
  SayState(link, {.x = 1, .rpm0 = 1500});
  std::uint64_t refused = 0;
  for (const wire::AfcsState& bad : {wire::AfcsState{.x = std::nan(""), .rpm0 = 1500},
                                     {.x = 3e38, .rpm0 = 1500},
                                     {.vz = 1e4, .rpm0 = 1500}}) {
    Say(bad);
    ++refused;
    ASSERT_TRUE(Eventually([&] { return link.Health().refused >= refused; })) << refused;
    EXPECT_EQ(link.State().p_NB.x(), 1);
    EXPECT_THAT(link.Health().error, HasSubstr("cannot be"));
  }
}

TEST_F(AfcsLinkTest, AStrangerIsNotHeard) {
  AfcsLink link(options_);
  ASSERT_TRUE(Next<wire::AfcsOpen>());
  const UdpPeer::Endpoint link_at = far_.to();
  Say(wire::AfcsAck{1});
  ASSERT_TRUE(Eventually([&] { return link.Health().open; }));
  UdpPeer stranger;
  stranger.To(link_at);
  stranger.Send({900, 0}, wire::AfcsState{.x = 66, .rpm0 = 1500});
  stranger.Send({900, 1}, wire::AfcsClose{});
  SayState(link, {.x = 1, .rpm0 = 1500});  // in the order of arrival, so the stranger's came before
  EXPECT_EQ(link.State().p_NB.x(), 1);
  EXPECT_TRUE(link.Health().open);
}

TEST_F(AfcsLinkTest, AVelocityIsTeleoperationThatMakesUpForOffsetAndDeadZone) {
  options_.afcs.teleop = {{0.20, 0.05}, {-0.10, 0.02}, {0.30, 0.10}, {0.04, 0.01}, true};
  AfcsLink link(options_);
  Open(link);
  link.Send(VelocitySetpoint{{0.5, -0.25, 0.125}, 0.0625});
  auto teleop = Next<wire::AfcsTeleop>();
  ASSERT_TRUE(teleop);
  EXPECT_NEAR(teleop->fore, 0.5 + 0.25, 1e-15);
  EXPECT_NEAR(teleop->side, -0.25 - 0.12, 1e-15);
  EXPECT_NEAR(teleop->alt, -0.125 + 0.20, 1e-15);
  EXPECT_NEAR(teleop->hdg, 0.0625 + 0.05, 1e-15);
  link.Send(VelocitySetpoint{});
  ASSERT_TRUE(Eventually([&] {
    teleop = Next<wire::AfcsTeleop>();
    return teleop == wire::AfcsTeleop{0.20, -0.10, 0.30, 0.04};
  }));
}

TEST_F(AfcsLinkTest, APlaceIsFlownToAndWhatIsConfirmedIsTold) {
  options_.afcs.fly_to_position = 3, options_.afcs.fly_to_heading = 4;
  AfcsLink link(options_);
  Open(link);
  link.Send(PositionSetpoint{{1, 2, -3}, 0.5});
  EXPECT_EQ(Next<wire::AfcsFlyTo>(), (wire::AfcsFlyTo{3, 4, 0, 1, 2, -3, 0.5}));
  EXPECT_FALSE(link.Desired());
  Say(wire::AfcsDesiredPosition{1, 2, -3, 0.5});
  ASSERT_TRUE(Eventually([&] { return link.Desired().has_value(); }));
  EXPECT_EQ(link.Desired()->p_N, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(link.Desired()->yaw, 0.5);
}

TEST_F(AfcsLinkTest, APlaceThatNobodyConfirmsIsTrouble) {
  options_.silent_s = 0.3;
  AfcsLink link(options_);
  Open(link);
  EXPECT_TRUE(Eventually([&] {
    Say(wire::AfcsAck{1});
    Say(wire::AfcsState{.rpm0 = 1500});
    link.Send(PositionSetpoint{});
    return link.Health().error.find("does not confirm") != std::string::npos;
  }));
}

TEST_F(AfcsLinkTest, AnAttitudeIsTroubleByNameAndEndsWhatWasAskedForBefore) {
  AfcsLink link(options_);
  Open(link);
  link.Send(VelocitySetpoint{{1, 0, 0}, 0});
  ASSERT_TRUE(Next<wire::AfcsTeleop>());
  link.Send(AttitudeSetpoint{});
  const double then_s = MonotonicTestNow_s();
  EXPECT_THAT(link.Health().error, HasSubstr("AttitudeSetpoint"));
  link.Send(RateSetpoint{});
  EXPECT_THAT(link.Health().error, HasSubstr("RateSetpoint"));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(Next<wire::AfcsOpen>());  // 0.2 s
  link.Send(VelocitySetpoint{{2, 0, 0}, 0});
  EXPECT_EQ(link.Health().error, "");
  auto teleop = Next<wire::AfcsTeleop>();
  while (teleop && teleop->fore == 1) {  // sent before
    ASSERT_LE(wire::Seconds(stamp_), then_s + 5e-6);
    teleop = Next<wire::AfcsTeleop>();
  }
  EXPECT_EQ(teleop->fore, 2);
}

TEST_F(AfcsLinkTest, ASetpointOrAidThatCannotBeSaidIsTroubleByName) {
  AfcsLink link(options_);
  Open(link);
  link.Send(VelocitySetpoint{{std::numeric_limits<double>::infinity(), 0, 0}, 0});
  EXPECT_THAT(link.Health().error, HasSubstr("not finite"));
  link.Aid({});
  EXPECT_THAT(link.Health().error, HasSubstr("AttitudeAid"));
  EXPECT_EQ(link.Health().sent, 0U);
}

// Stamps are of the clock by which the link judges the time since Send.
TEST_F(AfcsLinkTest, ASetpointIsRepeatedForAWhileAndThenTheWireFallsSilent) {
  options_.repeat_hz = 100;
  AfcsLink link(options_);
  Open(link);
  int repeats = 0;
  for (int attempt = 0; attempt < 20 && repeats < 3; ++attempt) {
    const double sent_s = MonotonicTestNow_s();
    link.Send(VelocitySetpoint{{1, 0, 0}, 0});
    const double end_s = MonotonicTestNow_s() + AutopilotLink::kRepeat_s;
    repeats = 0;
    while (MonotonicTestNow_s() < end_s + 0.1) {
      while (const auto datagram = far_.Receive()) {
        if (!std::holds_alternative<wire::AfcsTeleop>(datagram->message)) continue;
        ++repeats;
        EXPECT_GE(wire::Seconds(datagram->time), sent_s - 1e-6);
        EXPECT_LE(wire::Seconds(datagram->time), end_s + 5e-6);
      }
    }
    EXPECT_EQ(link.State().mode, FlightMode::kStopped);  // VehicleState{}: there is none
  }
  EXPECT_GE(repeats, 3);
}

TEST_F(AfcsLinkTest, AfterSilenceNothingIsSentButTheSessionIsKept) {
  AfcsLink link(options_);
  Open(link);
  link.Send(VelocitySetpoint{{1, 0, 0}, 0});
  ASSERT_TRUE(Next<wire::AfcsTeleop>());
  link.Silence();
  const double then_s = MonotonicTestNow_s();
  int kept = 0;
  while (MonotonicTestNow_s() < then_s + AutopilotLink::kRepeat_s || kept < 2) {
    ASSERT_LT(MonotonicTestNow_s(), then_s + 20);
    while (const auto datagram = far_.Receive()) {
      if (std::holds_alternative<wire::AfcsTeleop>(datagram->message)) {
        EXPECT_LE(wire::Seconds(datagram->time), then_s + 5e-6);
      }
      kept += std::holds_alternative<wire::AfcsOpen>(datagram->message) ? 1 : 0;
    }
  }
}

TEST_F(AfcsLinkTest, OpensAnewWhenTheFarEndFallsSilentEvenIfItsClockBeganAnew) {
  options_.silent_s = 0.3;
  AfcsLink link(options_);
  Open(link);
  SayState(link, {.x = 1, .rpm0 = 1500});
  ASSERT_TRUE(Eventually([&] { return !link.Health().open; }));
  EXPECT_THAT(link.Health().error, HasSubstr("fell silent"));
  EXPECT_EQ(link.State().p_NB.x(), 1);
  EXPECT_GT(*link.Health().state_age_s, options_.silent_s);
  link.Send(VelocitySetpoint{{1, 0, 0}, 0});
  EXPECT_EQ(link.Health().sent, 0U);  // there is nobody to obey
  clock_ = {0, 0};
  const double before_s = MonotonicTestNow_s();
  ASSERT_TRUE(Eventually([&] {
    Say(wire::AfcsAck{1});
    Say(wire::AfcsState{.x = 2, .rpm0 = 1500});
    return link.State().p_NB.x() == 2;
  }));
  EXPECT_GE(link.State().t_s, before_s);
}

TEST_F(AfcsLinkTest, SaysCloseAtTheEnd) {
  {
    AfcsLink link(options_);
    Open(link);
  }
  EXPECT_TRUE(Next<wire::AfcsClose>());
}

TEST_F(AfcsLinkTest, OpensAnewWhenTheFarEndCloses) {
  AfcsLink link(options_);
  Open(link);
  Say(wire::AfcsClose{});
  ASSERT_TRUE(Eventually([&] { return !link.Health().open; }));
  Open(link);
}

TEST_F(AfcsLinkTest, ThePlatformIsAskedUntilAndAfterItAnswers) {
  options_.platform_hz = 50;
  options_.afcs.platform_relative = 5, options_.afcs.platform_absolute = 6, options_.afcs.platform_point = 7;
  AfcsLink link(options_);
  Open(link);
  EXPECT_FALSE(link.Platform());
  link.Point(0.1, 0.2, 0.3);
  const wire::AfcsPlatform relative{5, 0.1, 0.2, 0.3, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(Next<wire::AfcsPlatform>(), relative);
  EXPECT_EQ(Next<wire::AfcsPlatform>(), relative);
  const wire::AfcsPlatform answer{5, 0, 0.15, 0.25, 1, 2, 3, 4, 5, 6};
  Say(answer);
  ASSERT_TRUE(Eventually([&] { return link.Platform().has_value(); }));
  EXPECT_EQ(link.Platform(), answer);
  link.PointAbsolute(0.4, 0.5, 0.6);
  EXPECT_TRUE(Eventually(
      [&] { return Next<wire::AfcsPlatform>() == wire::AfcsPlatform{6, 0, 0, 0, 0.4, 0.5, 0.6, 0, 0, 0}; }));
  link.PointAt({7, 8, 9});
  EXPECT_TRUE(Eventually(
      [&] { return Next<wire::AfcsPlatform>() == wire::AfcsPlatform{7, 0, 0, 0, 0, 0, 0, 7, 8, 9}; }));
}

TEST_F(AfcsLinkTest, AHostThatIsNotKnownIsRefusedByName) {
  options_.host = "256.1.1.1.invalid";
  try {
    const AfcsLink link(options_);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("256.1.1.1.invalid"));
  }
}

}  // namespace
}  // namespace kestrel::control
