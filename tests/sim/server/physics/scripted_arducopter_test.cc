// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/server/physics/scripted_arducopter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/server/physics/ardupilot_json.h"
#include "sim/server/physics/ardupilot_physics.h"
#include "sim/server/physics/parameter_file.h"
#include "tests/sim/drafted_aircraft.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/parameters_read_back.h"
#include "tests/sim/server/wire_peer.h"
#include "tests/support/content.h"

namespace kestrel::sim {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

ArduPilotParameterMap PelicansFile() {
  return ReadArduPilotParameters(Content(KESTREL_SOURCE_DIR "/models/vehicles/pelican/ardupilot.parm"));
}

// The state in a line; none: it is none.
std::optional<ArduCopterState> StateIn(const control::wire::Bytes& bytes) {
  const nlohmann::json line = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!line.is_object()) return std::nullopt;
  const auto vector = [](const nlohmann::json& list) {
    return Eigen::Vector3d(list[0].get<double>(), list[1].get<double>(), list[2].get<double>());
  };
  const nlohmann::json& q = line["quaternion"];
  ArduCopterState s;
  s.t_s = line["timestamp"];
  s.p_N = vector(line["position"]), s.v_N = vector(line["velocity"]);
  s.w_B = vector(line["imu"]["gyro"]), s.specific_force_B = vector(line["imu"]["accel_body"]);
  s.R_NB = Eigen::Quaterniond(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>());
  return s;
}

// Flies an aircraft by ArduCopter over the wire; script: at each state, of what its pilot has it do. The truth at each
// exposure.
std::vector<Truth> FlyBy(SimulatorParameters p, ScriptedArduCopter& copter,
                         const std::function<void(double)>& script) {
  p.image.rate_hz = 20;
  ArduPilotPhysicsParameters parameters;
  parameters.port = 0;
  ArduPilotPhysics physics(parameters, p.vehicle);
  std::atomic<bool> over = false;
  std::thread peer([&] {
    const WirePeer wire(physics.Where());
    ardupilot::ServoPacket packet;
    packet.frame_rate_hz = static_cast<std::uint16_t>(copter.rate_hz());
    for (;; ++packet.frame_count) {
      wire.Send(ardupilot::EncodeServoPacket(packet));
      while (!over && !wire.Readable(20)) continue;
      const auto state = over ? std::nullopt : StateIn(wire.Receive());
      if (!state) return;
      const std::vector<int> pwm = copter.Step(*state);
      for (std::size_t i = 0; i < pwm.size(); ++i) packet.pwm_us[i] = static_cast<std::uint16_t>(pwm[i]);
      script(state->t_s);
    }
  });
  EXPECT_TRUE(physics.Begin());
  p.step_s = physics.step_s();
  Simulator simulator(p);
  simulator.FlyBy(&physics);
  std::vector<Truth> truths;
  while (simulator.Next()) truths.push_back(simulator.exposure());
  over = true;
  peer.join();
  return truths;
}

std::vector<std::string> RefusalsOf(const ArduPilotParameterMap& file) {
  ScriptedArduCopter copter(file);
  SimulatorParameters p = OnGround();
  p.duration_s = ScriptedArduCopter::kSettled_s + 0.5;
  FlyBy(p, copter, [](double) {});
  return copter.PreArm();
}

TEST(ScriptedArduCopter, ArmsByThePelicansFileAndByNothingLess) {
  EXPECT_THAT(RefusalsOf(PelicansFile()), IsEmpty());
  EXPECT_THAT(RefusalsOf({}), Contains(HasSubstr("frame class")));
  EXPECT_THAT(RefusalsOf({}), Contains(HasSubstr("Accel")));
  EXPECT_THAT(RefusalsOf({}), Contains(HasSubstr("Compass")));
  EXPECT_THAT(RefusalsOf({}), Not(Contains(HasSubstr("Gyro"))));  // it asks for 1200 states a second
  ArduPilotParameterMap slow = PelicansFile();
  slow["SIM_RATE_HZ"] = 500;
  EXPECT_THAT(RefusalsOf(slow), Contains(HasSubstr("Gyro 0 rate")));
}

// Largest distance from a place, and of height, in a span of time.
struct Spread {
  double across_m = 0, up_m = 0;
  int count = 0;
};
Spread SpreadOf(const std::vector<Truth>& truths, double from_s, double until_s,
                const Eigen::Vector3d& about) {
  Spread spread;
  for (const Truth& t : truths) {
    if (t.t_s < from_s || t.t_s > until_s) continue;
    const Eigen::Vector3d off = t.X_NB.p - about;
    spread.across_m = std::max(spread.across_m, off.head<2>().norm());
    spread.up_m = std::max(spread.up_m, std::abs(off.z()));
    ++spread.count;
  }
  return spread;
}

const Truth& At(const std::vector<Truth>& truths, double t_s) {
  return *std::ranges::min_element(truths, {}, [&](const Truth& t) { return std::abs(t.t_s - t_s); });
}

// How late, in s, the climbs follow setpoints that swing with this period, by the phases of the two.
double LagOf(const std::vector<Truth>& truths, double from_s, double until_s, double period_s) {
  double in_phase = 0, behind = 0;
  for (const Truth& t : truths) {
    if (t.t_s < from_s || t.t_s > until_s) continue;
    const double phase = 2 * std::numbers::pi * (t.t_s - from_s) / period_s;
    in_phase += t.v_N.z() * std::sin(phase), behind -= t.v_N.z() * std::cos(phase);
  }
  return std::atan2(behind, in_phase) / (2 * std::numbers::pi) * period_s;
}

// Arms, takes off to 3 m, hovers, swings up and down and goes north by setpoints of velocity, and is left alone.
TEST(ScriptedArduCopter, FliesThePelicanByItsFileAndHoldsWhenSetpointsEnd) {
  constexpr double kArm_s = 2.2, kHover_s = 10, kSwing_s = 14, kPeriod_s = 3.45,
                   kNorth_s = kSwing_s + 4 * kPeriod_s, kLast_s = kNorth_s + 5, kEnd_s = kLast_s + 9;
  ScriptedArduCopter copter(PelicansFile());
  SimulatorParameters p = OnGround();
  p.duration_s = kEnd_s;
  p.wind.mean_m_s = 1;
  const std::vector<Truth> truths = FlyBy(p, copter, [&](double t_s) {
    if (t_s > kArm_s && !copter.armed() && copter.Arm()) copter.TakeOff(3);
    const double phase = 2 * std::numbers::pi * (t_s - kSwing_s) / kPeriod_s;
    if (t_s >= kSwing_s && t_s < kNorth_s) copter.SetVelocity({0, 0, 1.2 * std::sin(phase)});
    if (t_s >= kNorth_s && t_s < kLast_s) copter.SetVelocity({0.8, 0, 0});
  });
  ASSERT_GT(truths.size(), 600U);
  const Eigen::Vector3d ground = truths.front().X_NB.p;

  const Spread hover = SpreadOf(truths, kHover_s, kSwing_s, ground - Eigen::Vector3d(0, 0, 3));
  EXPECT_GT(hover.count, 70);
  EXPECT_LT(hover.across_m, 0.05);
  EXPECT_LT(hover.up_m, 0.05);
  EXPECT_LT(std::abs(Degrees(WrapAngle(YawOf(truths.back().X_NB.R) - YawOf(truths.front().X_NB.R)))), 5);

  // As late as the real one was with setpoints that swung so: WPNAV_ACCEL_Z allows no more.
  EXPECT_NEAR(LagOf(truths, kSwing_s + kPeriod_s, kNorth_s, kPeriod_s), 0.85, 0.1);

  // Leaning forward it does not lean aside, as by the motors of another layout, with which it would fly all the same.
  double pitch = 0, roll = 0;
  for (const Truth& t : truths) {
    if (t.t_s < kNorth_s || t.t_s > kNorth_s + 1) continue;
    const TaitBryan lean = TaitBryanFromRotation(t.X_NB.R.toRotationMatrix());
    pitch = std::max(pitch, std::abs(lean.pitch)), roll = std::max(roll, std::abs(lean.roll));
  }
  EXPECT_GT(Degrees(pitch), 5);
  EXPECT_LT(Degrees(roll), 0.5);

  // The last setpoint is in force for GUID_TIMEOUT, then it stops and stays.
  EXPECT_NEAR(At(truths, kLast_s).v_N.x(), 0.8, 0.08);
  EXPECT_NEAR(At(truths, kLast_s + 2.8).v_N.x(), 0.8, 0.08);
  const Truth& stopped = At(truths, kLast_s + 6);
  EXPECT_NEAR(stopped.X_NB.p.x() - At(truths, kLast_s).X_NB.p.x(), 0.8 * (3 + 0.5), 0.5);
  const Spread held = SpreadOf(truths, kLast_s + 6, kEnd_s, stopped.X_NB.p);
  EXPECT_GT(held.count, 50);
  EXPECT_LT(held.across_m, 0.05);
  EXPECT_LT(held.up_m, 0.05);
}

TEST(ScriptedArduCopter, FliesWhatWasBegunByTheFileThatIsWrittenForIt) {
  VehicleDraft draft;
  draft.name = "begun", draft.rotors = 6, draft.mass_kg = 1.9, draft.arm_m = 0.27;
  const MultirotorParameters aircraft = DraftedAircraft(draft);
  SimulatorParameters p = OnGround();
  p.vehicle = aircraft;
  p.scene.vehicle_shape = MultirotorShape(aircraft);
  p.duration_s = 14;
  ScriptedArduCopter copter(ReadArduPilotParameters(ParameterText("ardupilot", "begun", aircraft)));
  const std::vector<Truth> truths = FlyBy(p, copter, [&](double t_s) {
    if (t_s > 2.2 && !copter.armed() && copter.Arm()) copter.TakeOff(2);
  });
  ASSERT_GT(truths.size(), 250U);
  const Spread hover = SpreadOf(truths, 10, 14, truths.front().X_NB.p - Eigen::Vector3d(0, 0, 2));
  EXPECT_GT(hover.count, 70);
  EXPECT_LT(hover.across_m, 0.05);
  EXPECT_LT(hover.up_m, 0.05);
}

}  // namespace
}  // namespace kestrel::sim
