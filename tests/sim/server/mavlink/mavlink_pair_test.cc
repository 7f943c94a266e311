// SPDX-License-Identifier: Apache-2.0
// Both ends of MAVLink on a line that loses, doubles and delays, in simulated time.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>

#include "control/link/mavlink_session.h"
#include "sim/server/mavlink/mavlink_vehicle.h"
#include "tests/sim/server/fake_aircraft.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;
using control::wire::Bytes;
using Eigen::Vector3d;

constexpr double kTick_s = 0.004;
constexpr std::array<const char*, 2> kDialects{"px4", "ardupilot"};

struct Line {
  double lost = 0, doubled = 0;              // shares
  double delay_s = 0.001, delay_more_s = 0;  // and up to so much more: then the order is lost
  std::function<bool(const Message&)> swallow = [](const Message&) { return false; };
};

class Direction {
 public:
  Direction(const Line& line, unsigned seed) : line_(line), random_(seed) {}
  void Push(double now_s, const Bytes& datagram) {
    const std::vector<Frame> frames = Parser(Formats()).Datagram(datagram);
    ASSERT_EQ(frames.size(), 1U);  // nothing is sent that is not whole
    const Message message = *Decode(frames[0]);
    if (line_.swallow(message)) return;
    passed.push_back(message);
    if (Chance() < line_.lost) return;
    const int copies = Chance() < line_.doubled ? 2 : 1;
    for (int i = 0; i < copies; ++i)
      under_way_.emplace(now_s + line_.delay_s + Chance() * line_.delay_more_s, datagram);
  }
  std::vector<Bytes> Pull(double now_s) {
    std::vector<Bytes> here;
    while (!under_way_.empty() && under_way_.begin()->first <= now_s) {
      here.push_back(under_way_.begin()->second);
      under_way_.erase(under_way_.begin());
    }
    return here;
  }
  template <class M>
  std::vector<M> All() const {
    std::vector<M> all;
    for (const Message& message : passed)
      if (const auto* m = std::get_if<M>(&message)) all.push_back(*m);
    return all;
  }
  int Commands(int command) const {
    int count = 0;
    for (const CommandLong& m : All<CommandLong>()) count += m.command == command ? 1 : 0;
    return count;
  }

  std::vector<Message> passed;  // what was sent, lost or not

 private:
  double Chance() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  Line line_;
  std::mt19937 random_;
  std::multimap<double, Bytes> under_way_;
};
constexpr int kSetMode = 176, kArm = 400, kTakeOffCommand = 22;

struct Pair {
  explicit Pair(const control::MavlinkOptions& link_options = {}, const std::string& dialect = "px4",
                const Line& line = {}, FakeAircraft its = Flying(5))
      : options{.dialect = dialect},
        aircraft(std::move(its)),
        link(link_options),
        vehicle(std::make_unique<MavlinkVehicle>(options)),
        up(line, 1),
        down(line, 2) {}

  void Tick() {
    now_s += kTick_s;
    aircraft.Step(kTick_s);
    for (const Bytes& datagram : down.Pull(now_s)) link.Receive(datagram, now_s);
    for (const Bytes& datagram : link.Due(now_s)) up.Push(now_s, datagram);
    for (const Bytes& datagram : up.Pull(now_s)) vehicle->Receive(datagram, now_s, aircraft);
    for (const Bytes& datagram : vehicle->Due(now_s, aircraft)) down.Push(now_s, datagram);
  }
  void Run(
      double duration_s, const std::function<void()>& each = [] {}) {
    for (const double end_s = now_s + duration_s; now_s < end_s;) Tick(), each();
  }
  // The flight code's frames, at 20 Hz.
  void Fly(const control::Setpoint& setpoint, double duration_s) {
    Run(duration_s, [&] {
      if (now_s < next_frame_s_) return;
      next_frame_s_ = now_s + 0.05;
      link.Send(setpoint, now_s);
    });
  }
  control::LinkHealth Health() const { return link.Health(now_s); }
  double Offset() const { return now_s - aircraft.state.t_s; }
  // The mode of the last heartbeat.
  std::uint32_t Mode() const { return down.All<Heartbeat>().back().custom_mode; }
  bool Armed() const { return (down.All<Heartbeat>().back().base_mode & 128) != 0; }
  const Dialect& dialect() const { return options.dialect == "px4" ? kPx4 : kArduPilot; }

  MavlinkServerOptions options;
  double now_s = 1000;
  FakeAircraft aircraft;
  control::MavlinkSession link;
  std::unique_ptr<MavlinkVehicle> vehicle;
  Direction up, down;

 private:
  double next_frame_s_ = 0;
};

const control::MavlinkOptions kTakes{.take_control = true};

TEST(MavlinkPair, TheStateIsTheAircraftsOnOurClock) {
  for (const char* dialect : kDialects) {
    Pair pair({}, dialect, {.delay_s = 0.020});
    EXPECT_FALSE(pair.Health().open);
    EXPECT_FALSE(pair.Health().state_age_s);
    EXPECT_FALSE(pair.Health().pilot_allows);
    pair.aircraft.following = control::VelocitySetpoint{{0.5, 0, 0.1}, 0.4};
    pair.Run(3);
    const control::VehicleState state = pair.link.State(), truth = pair.aircraft.state;
    EXPECT_EQ(pair.Health().error.find("the aircraft is the pilot's") == std::string::npos, false);
    EXPECT_LT(pair.Health().state_age_s.value(), 0.05);
    // Half the round trip is known: what is left are the milliseconds on the wire and the ticks.
    const double age_s = pair.now_s - state.t_s;
    EXPECT_GT(age_s, 0.015);
    EXPECT_LT(age_s, 0.060);
    EXPECT_NEAR((truth.p_NB.z() - state.p_NB.z()) / 0.1, age_s, 0.005);
    EXPECT_LT((state.v_N - truth.v_N).norm(), 0.03);
    EXPECT_NEAR(WrapAngle(YawOf(truth.R_NB) - YawOf(state.R_NB)), 0.4 * age_s, 0.003);
    EXPECT_LT((state.w_B - truth.w_B).norm(), 1e-6);
    EXPECT_EQ(state.mode, control::FlightMode::kHold);  // flown by somebody else
    EXPECT_FALSE(state.landed);
    EXPECT_EQ(pair.link.Health(pair.now_s).refused, 0U);
  }
}

TEST(MavlinkPair, WithoutTimesyncTheStateIsLateByTheDelay) {
  Line line{.delay_s = 0.040};
  line.swallow = [](const Message& m) { return std::holds_alternative<Timesync>(m); };
  Pair pair({}, "px4", line);
  pair.aircraft.following = control::VelocitySetpoint{{0, 0, 0.1}, 0};
  pair.Run(3);
  const double age_s = pair.now_s - pair.link.State().t_s;
  EXPECT_NEAR((pair.aircraft.state.p_NB.z() - pair.link.State().p_NB.z()) / 0.1, age_s + 0.040, 0.006);
}

TEST(MavlinkPair, ATimesyncOfAnotherClockIsNotBelieved) {
  // It answers by the time of day.
  Pair pair;
  Line deaf;
  deaf.swallow = [](const Message& m) { return std::holds_alternative<Timesync>(m); };
  pair.down = Direction(deaf, 1);
  Sender clock(1, 1);
  std::size_t answered = 0;
  pair.Run(3, [&] {
    const std::vector<Timesync> questions = pair.up.All<Timesync>();
    for (; answered < questions.size(); ++answered) {
      const Timesync answer{.tc1 = 1790000000000000000 + std::llround(1e9 * pair.now_s),
                            .ts1 = questions[answered].ts1};
      pair.link.Receive(clock.Encode(answer), pair.now_s);
    }
  });
  EXPECT_GT(answered, 3U);
  EXPECT_NEAR(pair.now_s - pair.link.State().t_s, 0.015, 0.015);
}

TEST(MavlinkPair, SetpointsOfEveryKindArriveAsTheyWereSent) {
  for (const char* dialect : kDialects) {
    Pair pair(kTakes, dialect);
    const control::VelocitySetpoint velocity{{0.5, -0.2, 0.1}, 0.3};
    pair.Fly(velocity, 3);
    EXPECT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    EXPECT_EQ(pair.Health().error, "");
    EXPECT_EQ(pair.Health().pilot_allows, true);
    const auto followed = std::get<control::VelocitySetpoint>(pair.aircraft.sent.back());
    EXPECT_LT((followed.v_H - velocity.v_H).norm(), 1e-6);
    EXPECT_NEAR(followed.yaw_rate, 0.3, 1e-6);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kVelocity);

    const control::PositionSetpoint position{{3, -4, -7}, 0.6};
    pair.Fly(position, 1);
    const auto place = std::get<control::PositionSetpoint>(pair.aircraft.sent.back());
    EXPECT_LT((place.p_N - position.p_N).norm(), 1e-6);
    EXPECT_NEAR(place.yaw, 0.6, 1e-6);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kPosition);

    const control::AttitudeSetpoint attitude{0.1, -0.2, 0.5, 0.45};
    const double before = YawOf(pair.aircraft.state.R_NB);
    pair.Fly(attitude, 2);
    const auto tilt = std::get<control::AttitudeSetpoint>(pair.aircraft.sent.back());
    EXPECT_NEAR(tilt.roll, 0.1, 1e-6);
    EXPECT_NEAR(tilt.pitch, -0.2, 1e-6);
    EXPECT_NEAR(tilt.thrust, 0.45, 1e-6);
    EXPECT_NEAR(tilt.yaw_rate, 0.5, 0.05);  // it is led to a heading that turns, too
    EXPECT_NEAR(WrapAngle(YawOf(pair.aircraft.state.R_NB) - before), 0.5 * 2, 0.03);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kAttitude);
    EXPECT_EQ(pair.up.Commands(kSetMode), 1);
    EXPECT_EQ(pair.up.Commands(kArm), 0);
  }
}

TEST(MavlinkPair, SetpointsAreRepeatedWhileFreshAndThenStop) {
  Pair pair;
  pair.Run(0.5);
  pair.link.Send(control::VelocitySetpoint{}, pair.now_s);
  const auto count = [&] { return pair.up.All<SetPositionTargetLocalNed>().size(); };
  pair.Run(control::AutopilotLink::kRepeat_s);
  EXPECT_GE(count(), 0.25 * 20);
  EXPECT_EQ(count(), pair.Health().sent);
  pair.Run(kTick_s);
  const std::size_t fresh = count();
  pair.Run(1);
  EXPECT_EQ(count(), fresh);
  pair.link.Send(control::VelocitySetpoint{}, pair.now_s);
  pair.link.Silence();
  pair.Run(1);
  EXPECT_EQ(count(), fresh);
}

TEST(MavlinkPair, TheModeIsAskedForOnceSetpointsHaveBeenStreaming) {
  Pair px4(kTakes, "px4");
  px4.Run(3);
  EXPECT_EQ(px4.up.Commands(kSetMode), 0);
  px4.Fly(control::VelocitySetpoint{}, 1.1);
  EXPECT_EQ(px4.up.Commands(kSetMode), 0);
  px4.Fly(control::VelocitySetpoint{}, 0.3);
  EXPECT_EQ(px4.up.Commands(kSetMode), 1);
  EXPECT_EQ(px4.Mode(), kPx4.setpoint_mode);  // or it would have been refused

  Pair ardupilot(kTakes, "ardupilot");
  ardupilot.Run(1);
  ardupilot.Fly(control::VelocitySetpoint{}, 0.1);
  EXPECT_EQ(ardupilot.Mode(), kArduPilot.setpoint_mode);

  for (const char* dialect : kDialects) {
    Pair untold({}, dialect);
    untold.Fly(control::VelocitySetpoint{}, 5);
    EXPECT_EQ(untold.up.Commands(kSetMode), 0);
    EXPECT_EQ(untold.Health().pilot_allows, false);
    EXPECT_TRUE(untold.aircraft.sent.empty());
  }
}

TEST(MavlinkPair, Px4RefusesTheModeWithoutSetpoints) {
  Pair pair;
  pair.Run(0.5);
  Sender companion(1, 191);
  const auto ask = [&] {
    pair.vehicle->Receive(companion.Encode(SetCustomMode(kPx4.setpoint_mode, kPx4, {})), pair.now_s,
                          pair.aircraft);
    pair.Tick();
    return pair.down.All<CommandAck>().back().result;
  };
  EXPECT_NE(ask(), 0);
  pair.Fly(control::VelocitySetpoint{}, 0.9);
  EXPECT_NE(ask(), 0);
  pair.Fly(control::VelocitySetpoint{}, 0.2);
  EXPECT_EQ(ask(), 0);
}

TEST(MavlinkPair, Px4LeavesTheModeWhenSetpointsStopAndItIsNotTakenBack) {
  Pair pair(kTakes, "px4");
  pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 3);
  ASSERT_EQ(pair.Mode(), kPx4.setpoint_mode);
  pair.link.Silence();
  // It follows the last one until its time-out, then stops.
  pair.Run(0.9);
  EXPECT_EQ(pair.Mode(), kPx4.setpoint_mode);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(pair.aircraft.sent.back()).v_H.x(), 1);
  EXPECT_NEAR(pair.aircraft.sent_at_s, pair.aircraft.state.t_s, 1e-9);
  pair.Run(0.2);
  EXPECT_NE(pair.Mode(), kPx4.setpoint_mode);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(pair.aircraft.sent.back()).v_H.x(), 0);
  const std::size_t sent = pair.aircraft.sent.size();
  pair.Run(0.5);
  EXPECT_EQ(pair.Health().pilot_allows, false);
  EXPECT_NE(pair.Health().error, "");
  const int asked = pair.up.Commands(kSetMode);
  pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 4);
  EXPECT_EQ(pair.up.Commands(kSetMode), asked);
  EXPECT_EQ(pair.aircraft.sent.size(), sent);
  pair.link.TakeControl();
  EXPECT_EQ(pair.Health().pilot_allows, true);
  pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 1);
  EXPECT_EQ(pair.Mode(), kPx4.setpoint_mode);
  EXPECT_EQ(pair.up.Commands(kSetMode), asked + 1);
}

TEST(MavlinkPair, ArduPilotStopsAfterThreeSecondsButFliesOnToPositions) {
  Pair pair(kTakes, "ardupilot");
  pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 2);
  pair.link.Silence();
  pair.Run(2.9);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(pair.aircraft.sent.back()).v_H.x(), 1);
  pair.Run(0.2);
  EXPECT_EQ(std::get<control::VelocitySetpoint>(pair.aircraft.sent.back()).v_H.x(), 0);
  const std::size_t sent = pair.aircraft.sent.size();
  pair.Run(2);
  EXPECT_EQ(pair.aircraft.sent.size(), sent);
  EXPECT_EQ(pair.Mode(), kArduPilot.setpoint_mode);
  pair.Fly(control::PositionSetpoint{{30, 0, -5}, 0}, 0.5);
  pair.link.Silence();
  pair.Run(5);
  EXPECT_TRUE(std::holds_alternative<control::PositionSetpoint>(pair.aircraft.sent.back()));
  EXPECT_NEAR(pair.aircraft.sent_at_s, pair.aircraft.state.t_s, 1e-9);
}

TEST(MavlinkPair, ThePilotTakesOverAndIsNotOverruled) {
  for (const char* dialect : kDialects) {
    control::MavlinkOptions options = kTakes;
    options.switch_channel = 7;
    Pair pair(options, dialect);
    pair.Run(1.5);
    pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 3);
    ASSERT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    EXPECT_EQ(pair.Health().pilot_allows, true);
    const int asked = pair.up.Commands(kSetMode);
    pair.vehicle->SetPilot(false);
    pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 0.3);
    EXPECT_EQ(pair.Health().pilot_allows, false);
    EXPECT_EQ(std::get<control::VelocitySetpoint>(pair.aircraft.sent.back()).v_H.x(), 0);
    const std::size_t sent = pair.aircraft.sent.size();
    pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 5);
    EXPECT_EQ(pair.up.Commands(kSetMode), asked);
    EXPECT_EQ(pair.aircraft.sent.size(), sent);
    // Even when told: his switch is off.
    pair.link.TakeControl();
    pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 2);
    EXPECT_EQ(pair.up.Commands(kSetMode), asked);
    // He gives it back by his switch.
    pair.vehicle->SetPilot(true);
    pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 1);
    EXPECT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    EXPECT_EQ(pair.Health().pilot_allows, true);
    EXPECT_GT(pair.aircraft.sent.size(), sent);
  }
}

TEST(MavlinkPair, EachSetpointIsCountedOnceAndWhatIsNotHeededByItsKind) {
  Pair pair(kTakes);
  pair.Run(1.5);
  pair.Fly(control::VelocitySetpoint{{1, 0, 0}, 0}, 3);
  pair.link.Silence();
  pair.Run(0.1);
  const WireCounts& heard = pair.vehicle->received();
  EXPECT_EQ(heard.setpoints, pair.up.All<SetPositionTargetLocalNed>().size());
  EXPECT_GT(pair.aircraft.sent.size(), heard.setpoints);  // it is told again at each step
  EXPECT_GT(heard.followed, 20U);
  // PX4 has them before the mode, too.
  ASSERT_EQ(heard.ignored.size(), 1U);
  EXPECT_EQ(heard.ignored.at(ignored::kOtherMode).count, heard.setpoints - heard.followed);

  Sender sender(255, 190);
  auto target =
      std::get<SetPositionTargetLocalNed>(ToMessage(control::VelocitySetpoint{{1, 0, 0}, 0}, 0, kPx4, {}, 0));
  target.vy = std::numeric_limits<float>::quiet_NaN();
  pair.vehicle->Receive(sender.Encode(target), pair.now_s, pair.aircraft);
  target.vy = 0, target.coordinate_frame = 99;
  pair.vehicle->Receive(sender.Encode(target), pair.now_s, pair.aircraft);
  EXPECT_EQ(heard.refused, 2U);
  EXPECT_EQ(heard.ignored.at(ignored::kImpossible).count, 2U);
  EXPECT_NE(heard.ignored.at(ignored::kImpossible).first.find("nan"), std::string::npos);
  Bytes damaged = sender.Encode(CompanionHeartbeat());
  damaged[12] ^= 1;
  pair.vehicle->Receive(damaged, pair.now_s, pair.aircraft);
  EXPECT_EQ(heard.ignored.at(ignored::kDamaged).count, 1U);
}

TEST(MavlinkPair, ASwitchThatIsNotToldAllowsNothing) {
  control::MavlinkOptions options = kTakes;
  options.switch_channel = 9;  // the vehicle tells eight channels
  Pair pair(options);
  pair.Fly(control::VelocitySetpoint{}, 4);
  EXPECT_EQ(pair.Health().pilot_allows, false);
  EXPECT_EQ(pair.up.Commands(kSetMode), 0);
}

TEST(MavlinkPair, StandingByLetsThePilotEnterTheMode) {
  control::MavlinkOptions options;
  options.stand_by = true;
  Pair pair(options);
  pair.vehicle->SetPilot(false);
  pair.Run(3);
  EXPECT_GT(pair.up.All<SetPositionTargetLocalNed>().size(), 20U);
  EXPECT_EQ(pair.Health().sent, 0U);
  EXPECT_EQ(pair.Health().pilot_allows, false);
  pair.vehicle->SetPilot(true);
  pair.Run(0.2);
  EXPECT_EQ(pair.Mode(), kPx4.setpoint_mode);
  EXPECT_EQ(pair.Health().pilot_allows, true);
  const std::size_t stood_by = pair.up.All<SetPositionTargetLocalNed>().size();
  pair.Run(0.5);
  EXPECT_EQ(pair.up.All<SetPositionTargetLocalNed>().size(), stood_by);  // now it is the flight code's
}

FakeAircraft OnTheGround() {
  FakeAircraft aircraft;
  aircraft.state.t_s = 50;
  return aircraft;
}

TEST(MavlinkPair, APositionAboveArmsAndTakesOffWhereThatIsAllowed) {
  for (const char* dialect : kDialects) {
    control::MavlinkOptions options = kTakes;
    options.arm = true;
    Pair pair(options, dialect, {}, OnTheGround());
    pair.Run(1.5);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kStopped);
    EXPECT_TRUE(pair.link.State().landed);
    pair.Fly(control::VelocitySetpoint{}, 3);  // no take-off
    EXPECT_EQ(pair.up.Commands(kArm), 0);
    const std::size_t before = pair.up.All<SetPositionTargetLocalNed>().size();
    const control::PositionSetpoint above{{0, 0, -3}, 0};
    bool rose = false;
    const auto fly = [&](double duration_s) {
      for (int i = 0; i < std::lround(duration_s / 0.05); ++i) {
        pair.Fly(above, 0.05);
        rose = rose || pair.link.State().mode == control::FlightMode::kTakeOff;
        if (!pair.dialect().takes_off_by_setpoint &&
            pair.aircraft.state.mode == control::FlightMode::kStopped) {
          EXPECT_EQ(pair.up.All<SetPositionTargetLocalNed>().size(), before);
        }
      }
    };
    fly(5);
    EXPECT_TRUE(pair.Armed());
    EXPECT_EQ(pair.up.Commands(kArm), 1);
    EXPECT_EQ(pair.up.Commands(kTakeOffCommand), pair.dialect().takes_off_by_setpoint ? 0 : 1);
    EXPECT_TRUE(rose);
    EXPECT_LT((pair.aircraft.state.p_NB - above.p_N).norm(), 0.1);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kPosition);
    EXPECT_FALSE(pair.link.State().landed);

    // Down again: the touch-down logic stops the motors, and nobody starts them again.
    pair.Fly(control::VelocitySetpoint{{0, 0, 1}, 0}, 5);
    EXPECT_FALSE(pair.Armed());
    EXPECT_EQ(pair.up.Commands(kArm), 1);
    EXPECT_EQ(pair.link.State().mode, control::FlightMode::kStopped);
    EXPECT_TRUE(pair.link.State().landed);
  }
}

TEST(MavlinkPair, NothingIsArmedUnlessThatIsAllowed) {
  for (const char* dialect : kDialects) {
    Pair pair(kTakes, dialect, {}, OnTheGround());
    pair.Run(1.5);
    pair.Fly(control::PositionSetpoint{{0, 0, -3}, 0}, 4);
    EXPECT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    EXPECT_EQ(pair.up.Commands(kArm), 0);
    EXPECT_EQ(pair.aircraft.state.p_NB.z(), 0);
  }
}

TEST(MavlinkPair, FliesOnALineThatLosesDoublesAndReorders) {
  for (const char* dialect : kDialects) {
    Line bad;
    bad.lost = 0.3, bad.doubled = 0.2, bad.delay_s = 0.005, bad.delay_more_s = 0.1;
    Pair pair(kTakes, dialect, bad);
    const Vector3d target(4, -3, -8);
    double time_s = -1, oldest_s = 0, next_s = 0, worst_s = 0;
    pair.Run(20, [&] {
      const control::VehicleState state = pair.link.State();
      EXPECT_GE(state.t_s,
                time_s - 0.05);  // the offset may be learnt better; the aircraft's time is never old
      time_s = state.t_s;
      const control::LinkHealth health = pair.Health();
      if (pair.now_s > 1003) {
        oldest_s = std::max(oldest_s, health.state_age_s.value_or(99));
        const Vector3d v = pair.aircraft.state.v_N;
        if (v.z() < -0.1)  // by how much the time told of the state is wrong
          worst_s = std::max(worst_s, std::abs((pair.aircraft.state.p_NB - state.p_NB).z() / v.z() -
                                               (pair.now_s - state.t_s)));
      }
      if (pair.now_s < next_s) return;
      next_s = pair.now_s + 0.05;
      const Vector3d way = HeadingRotation(-YawOf(state.R_NB)) * (target - state.p_NB);
      pair.link.Send(control::VelocitySetpoint{way / std::max(1.0, way.norm()), 0.2}, pair.now_s);
    });
    EXPECT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    EXPECT_LT((pair.aircraft.state.p_NB - target).norm(), 0.1);
    EXPECT_LT(oldest_s, 0.3);
    EXPECT_LT(worst_s, 0.1);
    EXPECT_GT(pair.Health().refused, 100U);
    EXPECT_EQ(pair.Health().pilot_allows, true);
  }
}

TEST(MavlinkPair, AFarEndThatStartsAnewIsHeardAgainAndNotTakenAgain) {
  for (const char* dialect : kDialects) {
    Pair pair(kTakes, dialect);
    pair.Fly(control::VelocitySetpoint{{0.1, 0, 0}, 0}, 3);
    ASSERT_EQ(pair.Mode(), pair.dialect().setpoint_mode);
    pair.aircraft = Flying(2);
    pair.aircraft.state.t_s = 0;
    pair.vehicle = std::make_unique<MavlinkVehicle>(pair.options);
    const int asked = pair.up.Commands(kSetMode);
    pair.Fly(control::VelocitySetpoint{{0.1, 0, 0}, 0}, 4);
    EXPECT_LT(pair.Health().state_age_s.value(), 0.1);
    EXPECT_NEAR(pair.link.State().p_NB.z(), -2, 1e-6);
    EXPECT_NEAR(pair.now_s - pair.link.State().t_s, 0.015, 0.015);
    EXPECT_EQ(pair.up.Commands(kSetMode), asked);
    EXPECT_EQ(pair.Health().pilot_allows, false);
    EXPECT_TRUE(pair.aircraft.sent.empty());
  }
}

TEST(MavlinkPair, ALineThatIsCutIsTold) {
  Pair pair(kTakes);
  pair.Fly(control::VelocitySetpoint{}, 3);
  Line cut;
  cut.swallow = [](const Message&) { return true; };
  pair.down = Direction(cut, 1);
  pair.Run(1);
  EXPECT_NEAR(pair.Health().state_age_s.value(), 1, 0.05);
  EXPECT_NE(pair.Health().error, "");
  pair.Run(3);
  EXPECT_FALSE(pair.Health().open);
  EXPECT_FALSE(pair.Health().pilot_allows);
}

// The safety layer holds within its state_s of 0.5 s: the age says so in time, whichever part is missed.
TEST(MavlinkPair, AStateOfWhichOnlyAPartIsStillGoodIsAsOldAsTheOther) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto is_position = [](const Message& m) { return std::holds_alternative<LocalPositionNed>(m); };
  const auto is_attitude = [](const Message& m) {
    return std::holds_alternative<AttitudeQuaternion>(m) || std::holds_alternative<Attitude>(m);
  };
  for (const char* dialect : kDialects)
    for (const Message& bad : {Message(LocalPositionNed{.x = nan}), Message(LocalPositionNed{.vy = inf}),
                               Message(LocalPositionNed{.x = 3e38F}),
                               Message(AttitudeQuaternion{.q1 = 0, .q2 = 0, .q3 = 0, .q4 = 0}),
                               Message(AttitudeQuaternion{.q1 = 1, .yawspeed = nan})}) {
      Pair pair(kTakes, dialect);
      pair.Fly(control::VelocitySetpoint{}, 3);
      ASSERT_LT(pair.Health().state_age_s.value(), 0.05);
      Line cut;
      const bool position = is_position(bad);
      cut.swallow = [&, position](const Message& m) { return position ? is_position(m) : is_attitude(m); };
      pair.down = Direction(cut, 1);
      const double from_s = pair.now_s;
      Sender sender(1, 1);
      pair.Run(0.49, [&] {
        Message now = bad;
        const auto ms = static_cast<std::uint32_t>(std::lround(1e3 * pair.aircraft.state.t_s));
        if (auto* p = std::get_if<LocalPositionNed>(&now)) p->time_boot_ms = ms;
        if (auto* a = std::get_if<AttitudeQuaternion>(&now)) a->time_boot_ms = ms;
        pair.link.Receive(sender.Encode(now), pair.now_s);
      });
      EXPECT_NEAR(pair.Health().state_age_s.value(), pair.now_s - from_s, 0.03) << dialect << bad.index();
      EXPECT_GT(pair.Health().refused, 50U);
    }
}

TEST(MavlinkPair, OurOwnServerSaysThatItsAircraftIsSimulatedAndOthersDoNot) {
  for (const char* dialect : kDialects) {
    Pair pair({}, dialect);
    pair.Run(2);
    EXPECT_TRUE(pair.Health().simulated) << dialect;
  }
  control::MavlinkSession link({});
  EXPECT_FALSE(link.Health(0).simulated);
  link.Receive(Sender(1, 1).Encode(Heartbeat{.type = 2, .autopilot = 12, .base_mode = 129}), 0);
  EXPECT_TRUE(link.Health(0).open);
  EXPECT_FALSE(link.Health(0).simulated);
}

// The pad lies two metres east of the origin of N, its long side to the south; the aircraft is over the origin and
// looks east.
control::Sighting PadToTheEast(double t_s) {
  control::Sighting sighting;
  sighting.t_s = t_s;
  sighting.p_TB = {0, 2, -5};
  sighting.R_TB = HeadingRotation(-M_PI / 2);
  for (int i = 0; i < 6; ++i) sighting.covariance(i, i) = 0.01 * (i + 1);
  return sighting;
}

TEST(MavlinkPair, TheTargetIsShownAsEachWantsIt) {
  control::MavlinkOptions options;
  options.landing_target = "landing_target";
  Pair px4(options), ardupilot(options, "ardupilot");
  for (Pair* pair : {&px4, &ardupilot}) {
    pair->aircraft.state.R_NB = HeadingRotation(M_PI / 2);
    pair->Run(2);
    pair->link.See(PadToTheEast(pair->now_s - 0.1));
    pair->Run(0.5);
    ASSERT_EQ(pair->up.All<LandingTarget>().size(), 1U);
    EXPECT_NEAR(1e-6 * static_cast<double>(pair->up.All<LandingTarget>()[0].time_usec), pair->now_s - 0.6,
                0.01);
    EXPECT_EQ(pair->vehicle->received().sightings.at("LANDING_TARGET"), 1U);
  }
  const LandingTarget in_n = px4.up.All<LandingTarget>()[0], in_b = ardupilot.up.All<LandingTarget>()[0];
  EXPECT_EQ(in_n.frame, 1);
  EXPECT_LT((Vector3d(in_n.x, in_n.y, in_n.z) - Vector3d(0, 2, 0)).norm(), 1e-5);
  EXPECT_EQ(in_b.frame, 12);
  EXPECT_LT((Vector3d(in_b.x, in_b.y, in_b.z) - Vector3d(2, 0, 5)).norm(), 1e-5);
}

TEST(MavlinkPair, TheFixIsToldAsEachTakesIt) {
  control::MavlinkOptions options;
  options.landing_target = "target_relative", options.vision_position = "odometry";
  Pair px4(options);
  px4.aircraft.state.R_NB = HeadingRotation(M_PI / 2);
  px4.Run(2);
  px4.link.See(PadToTheEast(px4.now_s - 0.1));
  px4.Run(0.1);
  ASSERT_EQ(px4.up.All<TargetRelative>().size(), 1U);
  const TargetRelative target = px4.up.All<TargetRelative>()[0];
  EXPECT_LT((Vector3d(target.x, target.y, target.z) - Vector3d(0, 2, 5)).norm(), 1e-5);
  // T is turned by half a turn from N: the deviations keep their axes.
  EXPECT_NEAR(target.pos_std[0], std::sqrt(0.01), 1e-5);
  EXPECT_NEAR(target.pos_std[1], std::sqrt(0.02), 1e-5);
  EXPECT_NEAR(target.yaw_std, std::sqrt(0.06), 1e-5);
  ASSERT_EQ(px4.up.All<Odometry>().size(), 1U);
  const Odometry odometry = px4.up.All<Odometry>()[0];
  EXPECT_EQ(odometry.frame_id, 20);
  EXPECT_EQ(odometry.child_frame_id, 12);
  EXPECT_LT((Vector3d(odometry.x, odometry.y, odometry.z) - Vector3d(0, 2, -5)).norm(), 1e-5);
  EXPECT_NEAR(odometry.q[0], std::cos(M_PI / 4), 1e-5);
  EXPECT_NEAR(odometry.q[3], -std::sin(M_PI / 4), 1e-5);
  EXPECT_TRUE(std::isnan(odometry.vx));
  // x, y, z in T; it looks along -y of T, so that roll is about it and pitch about x.
  const std::array<std::pair<std::size_t, double>, 6> diagonal{
      {{0, 0.01}, {6, 0.02}, {11, 0.03}, {15, 0.05}, {18, 0.04}, {20, 0.06}}};
  for (const auto& [at, value] : diagonal) EXPECT_NEAR(odometry.pose_covariance[at], value, 1e-6) << at;
  EXPECT_EQ(px4.vehicle->received().sightings.at("ODOMETRY"), 1U);
  EXPECT_EQ(px4.vehicle->received().sightings.at("TARGET_RELATIVE"), 1U);

  Pair refused(options, "ardupilot");
  refused.Run(2);
  refused.link.See(PadToTheEast(refused.now_s));
  refused.Run(0.1);
  EXPECT_TRUE(refused.up.All<Odometry>().empty());
  EXPECT_NE(refused.Health().error.find("TARGET_RELATIVE"), std::string::npos);

  control::MavlinkOptions by_place;
  by_place.vision_position = "vision_position_estimate";
  Pair ardupilot(by_place, "ardupilot");
  ardupilot.aircraft.state.R_NB = HeadingRotation(M_PI / 2);
  ardupilot.Run(2);
  ardupilot.link.See(PadToTheEast(ardupilot.now_s - 0.1));
  ardupilot.Run(0.1);
  ASSERT_EQ(ardupilot.up.All<VisionPositionEstimate>().size(), 1U);
  const VisionPositionEstimate place = ardupilot.up.All<VisionPositionEstimate>()[0];
  EXPECT_LT((Vector3d(place.x, place.y, place.z) - Vector3d(0, -2, -5)).norm(), 1e-5);  // west of the pad
  EXPECT_NEAR(place.yaw, M_PI / 2, 1e-5);
  EXPECT_NEAR(place.covariance[6], 0.02, 1e-6);
  EXPECT_EQ(ardupilot.Health().error.find("ArduPilot"), std::string::npos);
}

TEST(MavlinkPair, WhatCannotBeSaidIsNotSentAndIsTrouble) {
  Pair pair(kTakes);
  pair.link.Send(control::AttitudeSetpoint{0, 0, 0, 0.5}, pair.now_s);  // which way does it look?
  pair.Run(0.1);
  EXPECT_EQ(pair.Health().sent, 0U);
  pair.Fly(control::VelocitySetpoint{}, 3);
  EXPECT_EQ(pair.Health().error, "");
  const std::uint64_t sent = pair.Health().sent;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const control::Setpoint& bad : {control::Setpoint(control::VelocitySetpoint{{nan, 0, 0}, 0}),
                                       control::Setpoint(control::AttitudeSetpoint{0, 0, 0, 1.5})}) {
    pair.link.Send(bad, pair.now_s);
    pair.Tick();
    EXPECT_NE(pair.Health().error.find("setpoint not sent"), std::string::npos);
  }
  EXPECT_EQ(pair.Health().sent, sent);
  pair.Fly(control::VelocitySetpoint{}, 0.1);
  EXPECT_EQ(pair.Health().error, "");
  pair.link.Aid();
  EXPECT_NE(pair.Health().error, "");
}

TEST(MavlinkPair, OthersOnTheLineAreNotTheAutopilot) {
  Pair pair(kTakes);
  pair.Run(1);
  const control::VehicleState before = pair.link.State();
  Sender other(2, 1), gimbal(1, 154);
  for (Sender* sender : {&other, &gimbal}) {
    pair.link.Receive(
        sender->Encode(Heartbeat{.custom_mode = kPx4.setpoint_mode, .type = 2, .autopilot = 12}), pair.now_s);
    pair.link.Receive(sender->Encode(LocalPositionNed{.time_boot_ms = 4000000000U, .x = 99}), pair.now_s);
  }
  EXPECT_EQ(pair.link.State().p_NB, before.p_NB);
  EXPECT_EQ(pair.link.State().mode, control::FlightMode::kHold);
  pair.Run(1);
  EXPECT_LT(pair.Health().state_age_s.value(), 0.1);
}

TEST(MavlinkPair, OnlyACopterOfTheTwoIsFlown) {
  for (const Heartbeat& heartbeat :
       {Heartbeat{.type = 1, .autopilot = 3}, Heartbeat{.type = 2, .autopilot = 0}}) {
    control::MavlinkSession link(kTakes);
    Sender sender(1, 1);
    link.Receive(sender.Encode(heartbeat), 0);
    link.Send(control::VelocitySetpoint{}, 0);
    EXPECT_FALSE(link.Open(0));
    EXPECT_NE(link.Health(0).error.find(heartbeat.type == 1 ? "rotorcraft" : "neither"), std::string::npos);
    EXPECT_EQ(link.Due(0).size(), 1U);  // its own heartbeat
  }
}

TEST(MavlinkPair, AConfusedOrHostileStreamDoesNotDisturbTheState) {
  Pair pair;
  pair.Run(2);
  std::mt19937 random(5);
  const control::VehicleState before = pair.link.State();
  Sender vehicle(1, 1);
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged =
        vehicle.Encode(LocalPositionNed{.time_boot_ms = 60000U + static_cast<unsigned>(i), .x = 5});
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
    pair.link.Receive(damaged, pair.now_s);
    Bytes noise(random() % 300);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    pair.link.Receive(noise, pair.now_s);
    pair.vehicle->Receive(noise, pair.now_s, pair.aircraft);
  }
  EXPECT_EQ(pair.link.State().p_NB, before.p_NB);
  EXPECT_GT(pair.Health().refused, 2000U);
  EXPECT_TRUE(pair.aircraft.sent.empty());
}

}  // namespace
}  // namespace kestrel::sim
