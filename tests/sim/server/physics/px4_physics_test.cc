// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/px4_physics.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <deque>
#include <thread>
#include <utility>

#include "sim/server/physics/motor_layout.h"
#include "sim/server/physics/parameter_file.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/parameters_read_back.h"
#include "tests/sim/server/physics/px4_peer.h"

namespace kestrel::sim {
namespace {

namespace mav = control::wire::mavlink;

Px4PhysicsParameters AnyPort() {
  Px4PhysicsParameters p;
  p.port = 0;
  p.speed = 0;
  return p;
}

constexpr MotorCommands kStill{};

// Flies one flight of the server to its end.
struct Flown {
  std::vector<vision::Frame> frames;
  std::vector<Truth> truths;  // at the frames' exposures
  Truth last;
  std::uint64_t state_hash = 0;
};
Flown Fly(Px4Physics& physics, const SimulatorParameters& parameters) {
  Simulator simulator(parameters);
  simulator.FlyBy(&physics);
  Flown flown;
  while (const auto frame = simulator.Next()) {
    flown.frames.push_back({frame->image.clone(), frame->t_s, frame->sequence});
    flown.truths.push_back(simulator.exposure());
  }
  flown.last = simulator.truth();
  flown.state_hash = simulator.state_hash();
  return flown;
}

// Takes off and stays at 2 m, by what HIL_SENSOR and HIL_GPS say. Each message must be there in its time, and
// none before its turn.
void HoverByHil(const std::string& where, const TestPilot& instructed, std::atomic<bool>& orderly) {
  Px4Peer peer(where);
  TestPilot pilot = instructed;
  HilEstimator estimator;
  std::uint64_t expected_usec = 4000;
  int states = 0, fixes = 0;
  const auto other = [&](const mav::Message& m) {
    if (const auto* gps = std::get_if<mav::HilGps>(&m)) estimator.Take(*gps), ++fixes;
    if (std::holds_alternative<mav::HilStateQuaternion>(m)) ++states;
  };
  while (const auto sensor = peer.Await<mav::HilSensor>(other)) {
    if (sensor->time_usec != expected_usec) orderly = false;
    expected_usec += 4000;
    estimator.Take(*sensor);
    if (sensor->time_usec % 4000000 == 0 && peer.Waiting(20)) orderly = false;  // time goes on unanswered
    const double flying_s = estimator.t_s() - HilEstimator::kStill_s;
    if (flying_s <= 0) pilot.KeepHeading(YawOf(estimator.state().R_NA));
    peer.Answer(sensor->time_usec, flying_s > 0 ? pilot.Fly(flying_s, estimator.state(), 2) : kStill,
                flying_s > 0);
  }
  // Every 5 ms and 200 ms of some 15 s.
  if (std::abs(states - 3000) > 60 || std::abs(fixes - 75) > 2) orderly = false;
}

// motors: where the peer has them; layout: as the server calls it.
void HoverWith(const std::vector<PublishedMotor>& motors, const std::string& layout, SimulatorParameters p) {
  SCOPED_TRACE(layout);
  p.duration_s = 15;
  p.wind.mean_m_s = 1;
  std::atomic<bool> orderly = true;
  std::thread peer;
  Flown flown;
  {
    Px4Physics physics(AnyPort(), p.vehicle);
    EXPECT_EQ(physics.Motors(), layout);
    peer = std::thread(HoverByHil, physics.Where(), TestPilot(motors, 0, MultirotorOf(p.vehicle)),
                       std::ref(orderly));
    ASSERT_TRUE(physics.Begin());
    flown = Fly(physics, p);
    EXPECT_TRUE(physics.lockstep());
    EXPECT_EQ(physics.counts().flights, 1U);
    EXPECT_EQ(physics.counts().refused, 0U);
  }
  peer.join();
  EXPECT_TRUE(orderly);
  EXPECT_EQ(flown.frames.size(), 76U);
  int hovering = 0;
  for (std::size_t k = 0; k < flown.frames.size(); ++k) {
    EXPECT_NEAR(flown.frames[k].t_s, 0.2 * static_cast<double>(k), 1e-9);
    const Truth& truth = flown.truths[k];
    EXPECT_EQ(truth.t_s, flown.frames[k].t_s);
    EXPECT_TRUE(truth.touching || truth.t_s >= 1);
    if (truth.t_s < 5) continue;
    ++hovering;
    EXPECT_NEAR(truth.X_NB.p.z() - flown.truths[0].X_NB.p.z(), -2, 0.5) << truth.t_s;
    EXPECT_LT((truth.X_NB.p - flown.truths[0].X_NB.p).head<2>().norm(), 1.5) << truth.t_s;
    EXPECT_LT(std::abs(Degrees(YawOf(truth.X_NB.R))), 15) << truth.t_s;
  }
  EXPECT_EQ(hovering, 51);
  // The camera saw it: the same picture while it stands, another one from above.
  EXPECT_LT(cv::norm(flown.frames[0].image, flown.frames[3].image, cv::NORM_L1) / (32 * 24), 4);
  EXPECT_GT(cv::norm(flown.frames[0].image, flown.frames.back().image, cv::NORM_L1) / (32 * 24), 8);
}

TEST(Px4Physics, APeerTakesOffAndHoversByTheSensorsItIsSent) {
  for (const char* layout : {"quad-plus", "quad-x"}) {
    const SimulatorParameters p = OnGroundWith(layout);
    HoverWith(PublishedLayout(layout, MultirotorOf(p.vehicle).arm_m), layout, p);
  }
}

// Six rotors, the middle ones far out, that no autopilot has a name for.
TEST(Px4Physics, RotorsInNoLayoutFlyByTheParametersThatAreWrittenForThem) {
  MultirotorParameters aircraft;
  aircraft.mass_kg = 1.7;
  aircraft.rotors = {{0.17, 0.12, "clockwise"},     {0.17, -0.12, "counterclockwise"},
                     {0, 0.31, "counterclockwise"}, {0, -0.31, "clockwise"},
                     {-0.17, 0.12, "clockwise"},    {-0.17, -0.12, "counterclockwise"}};
  SimulatorParameters p = OnGround();
  p.vehicle = aircraft;
  p.scene.vehicle_shape = MultirotorShape(aircraft);
  const auto told = ReadPx4Parameters(ParameterText("px4", "any", aircraft));
  std::vector<PublishedMotor> motors;
  for (int i = 0; i < told.at("CA_ROTOR_COUNT"); ++i) {
    const std::string rotor = "CA_ROTOR" + std::to_string(i) + "_";
    motors.push_back({told.at(rotor + "PX"), told.at(rotor + "PY"), told.at(rotor + "KM") > 0 ? 1 : -1});
  }
  EXPECT_THROW(KnownMotorOrder(aircraft), std::runtime_error);
  HoverWith(motors, "6 rotors as listed", p);
}

// Answers so many sensors, each with whatever `answer` sends, and is gone. Their time stamps.
std::vector<std::uint64_t> Exchange(const std::string& where, int count,
                                    const std::function<void(Px4Peer&, std::uint64_t)>& answer) {
  Px4Peer peer(where);
  std::vector<std::uint64_t> stamps;
  for (int i = 0; i < count; ++i) {
    const auto sensor = peer.Await<mav::HilSensor>();
    if (!sensor) break;
    stamps.push_back(sensor->time_usec);
    answer(peer, sensor->time_usec);
  }
  return stamps;
}

TEST(Px4Physics, RepetitionsAndGarbageLetNoTimePass) {
  Px4Physics physics(AnyPort(), OnGround().vehicle);
  std::vector<std::uint64_t> stamps;
  std::thread peer([&] {
    stamps = Exchange(physics.Where(), 100, [](Px4Peer& p, std::uint64_t t) {
      if (t > 4000) p.Answer(t - 4000, kStill);  // of before
      p.wire().Send(control::wire::Bytes{0xFD, 0x51, 0x00, 0x12, 0x34});
      p.Answer(t, kStill);
      p.Answer(t, kStill);
      p.wire().Send(control::wire::Bytes(17, 0x55));
    });
  });
  ASSERT_TRUE(physics.Begin());
  const Flown flown = Fly(physics, OnGround());
  peer.join();
  ASSERT_EQ(stamps.size(), 100U);
  for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(stamps[i], 4000 * (i + 1));
  // Up to the sensors that nobody answered any more, or to the end of the line that was seen before them.
  EXPECT_GE(flown.last.t_s, 0.4 - 1e-9);
  EXPECT_LE(flown.last.t_s, 0.404 + 1e-9);
  EXPECT_GE(physics.counts().repeated, 100U);
  EXPECT_GT(physics.counts().stray_bytes, 100U);
}

TEST(Px4Physics, WhoConnectsAndIsSilentKeepsNobodyWaiting) {
  Px4Physics physics(AnyPort(), OnGround().vehicle);
  std::deque<WirePeer> silent;
  for (int i = 0; i < 8; ++i) silent.emplace_back(physics.Where());
  std::size_t served = 0;
  bool shown_out = true;
  std::thread peer([&] {
    served = Exchange(physics.Where(), 3, [](Px4Peer& p, std::uint64_t t) { p.Answer(t, kStill); }).size();
    for (const WirePeer& each : silent) shown_out = shown_out && each.Receive().empty();
    physics.Stop();
  });
  EXPECT_TRUE(physics.Begin());
  Fly(physics, OnGround());
  peer.join();
  EXPECT_EQ(served, 3U);  // and has not waited for half a minute: Px4Peer's patience
  EXPECT_TRUE(shown_out);
  EXPECT_EQ(physics.counts().flights, 1U);
  EXPECT_EQ(physics.counts().refused, 8U);
}

TEST(Px4Physics, APeerThatGoesAndComesBackBeginsAFlightAnew) {
  Px4Physics physics(AnyPort(), OnGround().vehicle);
  const auto still = [](Px4Peer& p, std::uint64_t t) { p.Answer(t, kStill); };
  bool shown_out = false;
  std::vector<std::uint64_t> first, second;
  std::thread peers([&] {
    {
      const WirePeer noise(physics.Where());  // no PX4
      noise.Send(control::wire::Bytes(400, 0x20));
      shown_out = noise.Receive().empty();
    }
    first = Exchange(physics.Where(), 50, still);
    second = Exchange(physics.Where(), 50, still);
    physics.Stop();
  });
  std::vector<Flown> flown;
  while (physics.Begin()) flown.push_back(Fly(physics, OnGround()));
  peers.join();
  EXPECT_TRUE(shown_out);
  EXPECT_EQ(first.size(), 50U);
  EXPECT_EQ(second, first);
  ASSERT_EQ(flown.size(), 2U);
  EXPECT_EQ(flown[0].state_hash, flown[1].state_hash);  // every bit
  EXPECT_EQ(physics.counts().flights, 2U);
}

TEST(Px4Physics, SensorsGoOutByTheClockUntilTheFirstLockstepAnswer) {
  Px4PhysicsParameters parameters = AnyPort();
  parameters.speed = 10;
  Px4Physics physics(parameters, OnGround().vehicle);
  std::vector<std::uint64_t> stamps;
  bool went_on = false;
  std::thread peer([&] {
    Px4Peer p(physics.Where());
    for (int i = 0; i < 20; ++i) {  // starting up
      const auto sensor = p.Await<mav::HilSensor>();
      if (!sensor) return;
      stamps.push_back(sensor->time_usec);
      if (i == 10) p.Answer(sensor->time_usec, kStill, false, false);  // not in lockstep
    }
    // One answer to the newest; then time stands still.
    p.Answer(stamps.back(), kStill);
    std::uint64_t last = 0;
    while (p.Waiting(300)) {
      const auto sensor = p.Await<mav::HilSensor>();
      if (!sensor) return;
      last = sensor->time_usec;
    }
    const std::uint64_t before = last;
    p.Answer(before, kStill);
    const auto next = p.Await<mav::HilSensor>();
    went_on = next && next->time_usec == before + 4000 && !p.Waiting(50);
  });
  ASSERT_TRUE(physics.Begin());
  Fly(physics, OnGround());
  peer.join();
  ASSERT_EQ(stamps.size(), 20U);
  for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(stamps[i], 4000 * (i + 1));
  EXPECT_TRUE(went_on);
}

TEST(Px4Physics, MotorsOfWhoIsNotArmedStandStill) {
  Px4Physics physics(AnyPort(), OnGround().vehicle);
  std::thread peer([&] {
    Exchange(physics.Where(), 250, [](Px4Peer& p, std::uint64_t t) {
      p.Answer(t, {0.9, 0.9, 0.9, 0.9}, false);
    });
  });
  ASSERT_TRUE(physics.Begin());
  const Flown flown = Fly(physics, OnGround());
  peer.join();
  EXPECT_TRUE(flown.last.touching);
  EXPECT_LT(flown.last.v_N.norm(), 1e-2);
}

TEST(Px4Physics, StopEndsEveryWait) {
  Px4Physics physics(AnyPort(), OnGround().vehicle);
  std::thread peer([&] {
    Px4Peer p(physics.Where());
    const auto sensor = p.Await<mav::HilSensor>();
    p.Answer(sensor ? sensor->time_usec : 0, kStill);
    p.Await<mav::HilSensor>();  // and is never answered
    physics.Stop();
    p.Await<mav::Statustext>();  // until it is closed
  });
  {
    ASSERT_TRUE(physics.Begin());
    Fly(physics, OnGround());
    EXPECT_FALSE(physics.Begin());
  }
  peer.join();
}

TEST(Px4Physics, SaysWhatIsTheMatter) {
  Px4PhysicsParameters p = AnyPort();
  const AirframeParameters pelican = OnGround().vehicle;
  Px4Physics physics(p, pelican);
  EXPECT_TRUE(physics.Where().starts_with("tcp://127.0.0.1:"));
  p.port = std::stoi(physics.Where().substr(physics.Where().rfind(':') + 1));
  EXPECT_THROW(Px4Physics(p, pelican), std::runtime_error);
  p = AnyPort(), p.address = "here";
  EXPECT_THROW(Px4Physics(p, pelican), std::runtime_error);
  EXPECT_THROW(Px4Physics(AnyPort(), HelicopterParameters{}), std::runtime_error);
}

}  // namespace
}  // namespace kestrel::sim
