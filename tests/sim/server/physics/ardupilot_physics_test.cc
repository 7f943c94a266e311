// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/ardupilot_physics.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>
#include <vector>

#include "sim/server/physics/ardupilot_json.h"
#include "sim/server/physics/motor_layout.h"
#include "tests/sim/drafted_aircraft.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/server/wire_peer.h"
#include "tests/sim/test_pilot.h"

namespace kestrel::sim {
namespace {

ArduPilotPhysicsParameters AnyPort() {
  ArduPilotPhysicsParameters p;
  p.port = 0;
  return p;
}

// What ArduPilot does at its end of the JSON interface: sends its servos, waits for the state.
class ArduPilotPeer {
 public:
  explicit ArduPilotPeer(const std::string& where) : wire_(where) {}

  void Send(std::uint32_t count, const MotorCommands& commands, int rate_hz) const {
    ardupilot::ServoPacket packet;
    packet.frame_rate_hz = static_cast<std::uint16_t>(rate_hz);
    packet.frame_count = count;
    for (std::size_t i = 0; i < commands.size(); ++i)
      packet.pwm_us[i] = static_cast<std::uint16_t>(1000 + std::lround(1000 * commands[i]));
    wire_.Send(ardupilot::EncodeServoPacket(packet));
  }
  // The state's line; null: none came.
  nlohmann::json Receive() const {
    const control::wire::Bytes bytes = wire_.Receive();
    const std::string text(bytes.begin(), bytes.end());
    if (text.size() < 2 || text.front() != '\n' || text.back() != '\n') return {};
    return nlohmann::json::parse(text, nullptr, false);
  }
  nlohmann::json Exchange(std::uint32_t count, const MotorCommands& commands = {}, int rate_hz = 400) const {
    Send(count, commands, rate_hz);
    return Receive();
  }
  const WirePeer& wire() const { return wire_; }

 private:
  WirePeer wire_;
};

Eigen::Vector3d Vector(const nlohmann::json& list) {
  const auto v = list.get<std::array<double, 3>>();
  return Eigen::Vector3d(v[0], v[1], v[2]);
}

double TimeOf(const nlohmann::json& state) {
  return state.is_object() ? state["timestamp"].get<double>() : -1;
}

PilotState StateOf(const nlohmann::json& line) {
  const auto q = line["quaternion"].get<std::array<double, 4>>();
  return {Vector(line["position"]), Vector(line["velocity"]), Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
          Vector(line["imu"]["gyro"])};
}

struct Flown {
  std::vector<Truth> truths;
  std::vector<double> frames_s;
  Truth last;
};
Flown Fly(ArduPilotPhysics& physics, const SimulatorParameters& parameters) {
  Simulator simulator(parameters);
  simulator.FlyBy(&physics);
  Flown flown;
  while (const auto frame = simulator.Next()) {
    flown.frames_s.push_back(frame->t_s);
    flown.truths.push_back(simulator.exposure());
  }
  flown.last = simulator.truth();
  return flown;
}

// A peer with the motors of a layout takes off and stays at 2 m.
void HoverBy(const std::string& layout, SimulatorParameters p) {
  SCOPED_TRACE(layout);
  p.duration_s = 15;
  p.wind.mean_m_s = 1;
  ArduPilotPhysics physics(AnyPort(), p.vehicle);
  EXPECT_EQ(physics.Motors(), layout);
  bool in_step = true;
  std::atomic<bool> over = false;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where());
    const MultirotorParameters& aircraft = MultirotorOf(p.vehicle);
    const double arm_m = LayoutOf(aircraft).hubs_B[0].head<2>().norm();
    TestPilot pilot(PublishedLayout(layout, arm_m), 0.65, aircraft);
    nlohmann::json line = ardupilot.Exchange(0);
    pilot.KeepHeading(YawOf(StateOf(line).R_NA));
    const double ground_m = StateOf(line).p_N.z();
    for (std::uint32_t i = 1; line.is_object(); ++i) {
      PilotState state = StateOf(line);
      state.p_N.z() -= ground_m;
      if (std::abs(TimeOf(line) - 0.002 * i) > 1e-9) in_step = false;
      if (i % 2000 == 0 && ardupilot.wire().Readable(20)) in_step = false;  // said more than was asked
      ardupilot.Send(i, pilot.Fly(TimeOf(line), state, 2), 400);
      while (!over && !ardupilot.wire().Readable(20)) continue;
      if (over) return;
      line = ardupilot.Receive();
    }
  });
  EXPECT_TRUE(physics.Begin());
  const Flown flown = Fly(physics, p);
  over = true;
  peer.join();
  EXPECT_TRUE(in_step);
  ASSERT_EQ(flown.truths.size(), 76U);
  for (std::size_t k = 0; k < flown.truths.size(); ++k) {
    EXPECT_NEAR(flown.frames_s[k], 0.2 * static_cast<double>(k), 1e-9);
    const Truth& truth = flown.truths[k];
    if (truth.t_s < 5) continue;
    EXPECT_NEAR(truth.X_NB.p.z() - flown.truths[0].X_NB.p.z(), -2, 0.25) << truth.t_s;
    EXPECT_LT((truth.X_NB.p - flown.truths[0].X_NB.p).head<2>().norm(), 0.5) << truth.t_s;
    EXPECT_LT(std::abs(Degrees(YawOf(truth.X_NB.R))), 5) << truth.t_s;
  }
}

TEST(ArduPilotPhysics, APeerTakesOffAndHoversByTheStateItIsSent) {
  for (const char* layout : {"quad-plus", "quad-x"}) HoverBy(layout, OnGroundWith(layout));
}

TEST(ArduPilotPhysics, AnAircraftThatWasBegunHoversByItsAutopilotsTable) {
  for (const auto& [shape, rotors, layout] :
       {std::tuple{"x", 6, "hexa-x"}, {"plus", 6, "hexa-plus"}, {"x", 8, "octo-x"}, {"h", 4, "quad-h"}}) {
    VehicleDraft draft;
    draft.name = "begun", draft.layout = shape, draft.rotors = rotors;
    draft.mass_kg = 2.3, draft.arm_m = 0.31;
    const MultirotorParameters aircraft = DraftedAircraft(draft);
    SimulatorParameters p = OnGround();
    p.vehicle = aircraft;
    p.scene.vehicle_shape = MultirotorShape(aircraft);
    HoverBy(layout, p);
  }
}

// As ArduCopter does, it arms only if its gyroscopes are faster than 1.8 times its loop of 400 Hz.
TEST(ArduPilotPhysics, APeerThatAsksForItsDefaultRateArmsAndFlies) {
  constexpr double kLoop_hz = 400, kMeasured_s = 1;
  for (const int rate_hz : {1200, 400}) {
    SimulatorParameters p = OnGround();
    p.duration_s = 10;
    ArduPilotPhysics physics(AnyPort(), p.vehicle);
    std::atomic<bool> over = false;
    double gyro_hz = 0;
    std::thread peer([&] {
      const ArduPilotPeer ardupilot(physics.Where());
      TestPilot pilot(PublishedLayout("quad-plus", MultirotorParameters().arm_m), 0.65);
      nlohmann::json line = ardupilot.Exchange(0, {}, rate_hz);
      pilot.KeepHeading(YawOf(StateOf(line).R_NA));
      const double ground_m = StateOf(line).p_N.z(), began_s = TimeOf(line);
      bool armed = false;
      for (std::uint32_t i = 1; line.is_object(); ++i) {
        const double t_s = TimeOf(line);
        if (gyro_hz == 0 && t_s - began_s >= kMeasured_s) {
          gyro_hz = i / (t_s - began_s);
          armed = gyro_hz > 1.8 * kLoop_hz;
        }
        PilotState state = StateOf(line);
        state.p_N.z() -= ground_m;
        ardupilot.Send(i, armed ? pilot.Fly(t_s, state, 2) : MotorCommands{}, rate_hz);
        while (!over && !ardupilot.wire().Readable(20)) continue;
        if (over) return;
        line = ardupilot.Receive();
      }
    });
    EXPECT_TRUE(physics.Begin());
    p.step_s = physics.step_s();
    const Flown flown = Fly(physics, p);
    over = true;
    peer.join();
    ASSERT_FALSE(flown.truths.empty());
    const double up_m = flown.truths[0].X_NB.p.z() - flown.last.X_NB.p.z();
    EXPECT_NEAR(gyro_hz, rate_hz == 1200 ? 1000 : 500, 2);
    EXPECT_NEAR(up_m, rate_hz == 1200 ? 2 : 0, 0.25) << rate_hz;
  }
}

TEST(ArduPilotPhysics, RepetitionsAreAnsweredAgainAndGarbageIsNot) {
  ArduPilotPhysics physics(AnyPort(), OnGround().vehicle);
  std::vector<nlohmann::json> lines;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where());
    for (std::uint32_t i = 0; i < 20; ++i) {
      ardupilot.wire().Send(control::wire::Bytes(40, 0x48));
      ardupilot.wire().Send(control::wire::Bytes{0x1A, 0x48});
      lines.push_back(ardupilot.Exchange(i));
      lines.push_back(ardupilot.Exchange(i));
      lines.push_back(ardupilot.Exchange(i));
    }
    physics.Stop();
  });
  ASSERT_TRUE(physics.Begin());
  Fly(physics, OnGround());
  peer.join();
  ASSERT_EQ(lines.size(), 60U);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_NEAR(TimeOf(lines[i]), 0.002 * static_cast<double>(i / 3 + 1), 1e-9);
    EXPECT_EQ(lines[i], lines[i - i % 3]);
  }
  EXPECT_EQ(physics.counts().repeated, 40U);
  EXPECT_EQ(physics.counts().refused, 40U);
  EXPECT_EQ(physics.counts().answers, 19U);
}

TEST(ArduPilotPhysics, TimeGoesOnByTheRateThatIsAskedFor) {
  ArduPilotPhysics physics(AnyPort(), OnGround().vehicle);
  std::vector<double> steps_s;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where());
    double before_s = 0;
    std::uint32_t count = 0;
    for (const int rate_hz : {1200, 500, 400, 250, 100, 1, 0}) {
      const double now_s = TimeOf(ardupilot.Exchange(count++, {}, rate_hz));
      steps_s.push_back(now_s - before_s);
      before_s = now_s;
    }
    physics.Stop();
  });
  ASSERT_TRUE(physics.Begin());
  Fly(physics, OnGround());
  peer.join();
  const std::vector<double> expected = {0.002, 0.002, 0.002, 0.004, 0.010, 0.098, 0.002};
  ASSERT_EQ(steps_s.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(steps_s[i], expected[i], 1e-9) << i;
}

TEST(ArduPilotPhysics, ACountThatBeginsAnewBeginsAFlight) {
  ArduPilotPhysics physics(AnyPort(), OnGround().vehicle);
  std::vector<nlohmann::json> first, second;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where());
    for (std::uint32_t i = 0; i < 60; ++i) first.push_back(ardupilot.Exchange(i, {0.3, 0.3, 0.3, 0.3}));
    for (std::uint32_t i = 0; i < 60; ++i) second.push_back(ardupilot.Exchange(i, {0.3, 0.3, 0.3, 0.3}));
    physics.Stop();
  });
  int flights = 0;
  while (physics.Begin()) {
    Fly(physics, OnGround());
    ++flights;
  }
  peer.join();
  EXPECT_EQ(flights, 2);
  EXPECT_EQ(first.size(), 60U);
  EXPECT_NEAR(TimeOf(first.back()), 0.120, 1e-9);
  EXPECT_EQ(first, second);  // the same flight to the last digit
}

TEST(ArduPilotPhysics, AnotherAddressIsRefusedWhileThePeerIsThere) {
  ArduPilotPhysicsParameters parameters = AnyPort();
  parameters.gone_s = 3600;
  ArduPilotPhysics physics(parameters, OnGround().vehicle);
  double first_s = 0, next_s = 0;
  bool refused = false;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where()), other(physics.Where());
    for (std::uint32_t i = 5; i < 15; ++i) first_s = TimeOf(ardupilot.Exchange(i));
    other.Send(15, {1, 1, 1, 1}, 400);
    next_s = TimeOf(ardupilot.Exchange(15));
    refused = !other.wire().Readable(0);
    physics.Stop();
  });
  int flights = 0;
  while (physics.Begin()) Fly(physics, OnGround()), ++flights;
  peer.join();
  EXPECT_NEAR(first_s, 0.020, 1e-9);
  EXPECT_NEAR(next_s, 0.022, 1e-9);
  EXPECT_TRUE(refused);
  EXPECT_LE(physics.counts().refused, 1U);  // 0: the peer's came before it was looked at
  EXPECT_EQ(flights, 1);
}

// Begins with a peer's packet 0 and flies; the peer reads two answers, which are not waited for for ever.
std::array<double, 2> TwoAnswers(ArduPilotPhysics& physics, const ArduPilotPeer& peer) {
  std::array<double, 2> times_s{};
  std::thread reader([&] {
    for (double& t_s : times_s) t_s = TimeOf(peer.Receive());
    physics.Stop();
  });
  Fly(physics, OnGround());
  reader.join();
  return times_s;
}

TEST(ArduPilotPhysics, AFloodDoesNotHideThePeer) {
  ArduPilotPhysicsParameters parameters = AnyPort();
  parameters.gone_s = 3600;
  ArduPilotPhysics physics(parameters, OnGround().vehicle);
  const ArduPilotPeer peer(physics.Where()), other(physics.Where());
  peer.Send(0, {}, 400);
  ASSERT_TRUE(physics.Begin());
  for (std::uint32_t i = 0; i < 4000; ++i) other.Send(i, {1, 1, 1, 1}, 400);  // more than a queue holds
  peer.Send(1, {}, 400);
  const auto times_s = TwoAnswers(physics, peer);
  EXPECT_NEAR(times_s[0], 0.002, 1e-9);
  EXPECT_NEAR(times_s[1], 0.004, 1e-9);
  EXPECT_FALSE(other.wire().Readable(0));
}

TEST(ArduPilotPhysics, APeerThatSpokeInTimeAndWasReadLateKeepsTheFlight) {
  ArduPilotPhysicsParameters parameters = AnyPort();
  parameters.gone_s = 0;  // silent: whoever has said nothing when it is asked
  ArduPilotPhysics physics(parameters, OnGround().vehicle);
  const ArduPilotPeer peer(physics.Where()), other(physics.Where());
  peer.Send(0, {}, 400);
  ASSERT_TRUE(physics.Begin());
  other.Send(7, {1, 1, 1, 1}, 400);
  peer.Send(1, {}, 400);
  const auto times_s = TwoAnswers(physics, peer);
  EXPECT_NEAR(times_s[0], 0.002, 1e-9);
  EXPECT_NEAR(times_s[1], 0.004, 1e-9);
}

TEST(ArduPilotPhysics, AnotherAddressBeginsAFlightWhenThePeerIsGone) {
  ArduPilotPhysicsParameters parameters = AnyPort();
  parameters.gone_s = 0;  // at once
  ArduPilotPhysics physics(parameters, OnGround().vehicle);
  double first_s = 0, other_s = 0;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where()), other(physics.Where());
    for (std::uint32_t i = 5; i < 15; ++i) first_s = TimeOf(ardupilot.Exchange(i));
    for (std::uint32_t i = 15; i < 18; ++i) other_s = TimeOf(other.Exchange(i));
    physics.Stop();
  });
  int flights = 0;
  while (physics.Begin()) Fly(physics, OnGround()), ++flights;
  peer.join();
  EXPECT_NEAR(first_s, 0.020, 1e-9);
  EXPECT_NEAR(other_s, 0.006, 1e-9);
  EXPECT_EQ(flights, 2);
}

TEST(ArduPilotPhysics, AFlightThatItsCallerLeftGoesOnAsAnother) {
  ArduPilotPhysics physics(AnyPort(), OnGround().vehicle);
  std::vector<double> times_s;
  std::thread peer([&] {
    const ArduPilotPeer ardupilot(physics.Where());
    for (std::uint32_t i = 0; i < 600; ++i) times_s.push_back(TimeOf(ardupilot.Exchange(i)));
    physics.Stop();
  });
  SimulatorParameters p = OnGround();
  p.duration_s = 0.5;  // the last frame is there at 0.45 s, for its latency
  int flights = 0;
  while (physics.Begin()) Fly(physics, p), ++flights;
  peer.join();
  ASSERT_EQ(times_s.size(), 600U);
  EXPECT_GE(flights, 2);
  int began = 0;
  for (std::size_t i = 1; i < times_s.size(); ++i) began += times_s[i] < times_s[i - 1];
  EXPECT_EQ(began, flights - 1);
}

TEST(ArduPilotPhysics, SaysWhatIsTheMatter) {
  ArduPilotPhysicsParameters p = AnyPort();
  const AirframeParameters pelican = OnGround().vehicle;
  const ArduPilotPhysics physics(p, pelican);
  EXPECT_TRUE(physics.Where().starts_with("udp://127.0.0.1:"));
  p.port = std::stoi(physics.Where().substr(physics.Where().rfind(':') + 1));
  EXPECT_THROW(ArduPilotPhysics(p, pelican), std::runtime_error);
  p = AnyPort(), p.address = "nowhere";
  EXPECT_THROW(ArduPilotPhysics(p, pelican), std::runtime_error);
  EXPECT_THROW(ArduPilotPhysics(AnyPort(), HelicopterParameters{}), std::runtime_error);
}

}  // namespace
}  // namespace kestrel::sim
