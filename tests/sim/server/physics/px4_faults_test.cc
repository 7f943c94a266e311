// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <thread>

#include "sim/server/physics/motor_layout.h"
#include "sim/server/physics/px4_physics.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/server/physics/px4_peer.h"

namespace kestrel::sim {
namespace {

namespace mav = control::wire::mavlink;

constexpr double kFlight_s = 4;
constexpr std::uint32_t kMagnetometer = 64, kBarometer = 512;

// What came, by the time stamps in s.
struct Heard {
  std::map<double, mav::HilGps> fixes;
  std::map<double, mav::HilSensor> fields, pressures;  // said to be new
};

// An aircraft on the ground, whose autopilot listens.
Heard Listen(const std::vector<SensorFault>& faults) {
  SimulatorParameters p = OnGround();
  p.duration_s = kFlight_s + 0.1;
  p.sensors.faults = faults;
  Px4PhysicsParameters parameters;
  parameters.port = 0, parameters.speed = 0;
  Px4Physics physics(parameters, p.vehicle);
  Heard heard;
  std::thread peer([&] {
    Px4Peer px4(physics.Where());
    const auto other = [&](const mav::Message& m) {
      if (const auto* gps = std::get_if<mav::HilGps>(&m))
        heard.fixes[static_cast<double>(gps->time_usec) * 1e-6] = *gps;
    };
    while (const auto sensor = px4.Await<mav::HilSensor>(other)) {
      const double t_s = static_cast<double>(sensor->time_usec) * 1e-6;
      if ((sensor->fields_updated & kMagnetometer) != 0) heard.fields[t_s] = *sensor;
      if ((sensor->fields_updated & kBarometer) != 0) heard.pressures[t_s] = *sensor;
      if (t_s > kFlight_s) break;
      px4.Answer(sensor->time_usec, MotorCommands{}, false);
    }
  });
  EXPECT_TRUE(physics.Begin());
  Simulator simulator(p);
  simulator.FlyBy(&physics);
  while (simulator.Next()) continue;
  peer.join();
  return heard;
}

SensorFault Fault(const std::string& component, const std::string& type, double from_s, double until_s) {
  SensorFault f;
  f.component = component, f.type = type, f.from_s = from_s, f.until_s = until_s;
  return f;
}

// Of the flight without faults: which times are missing in the other, and what is told otherwise.
template <class Message, class Differ>
std::pair<std::vector<double>, std::vector<double>> Compare(const std::map<double, Message>& sound,
                                                            const std::map<double, Message>& faulty,
                                                            Differ differ) {
  std::vector<double> missing, differing;
  for (const auto& [t_s, message] : sound) {
    const auto found = faulty.find(t_s);
    if (found == faulty.end())
      missing.push_back(t_s);
    else if (differ(message, found->second))
      differing.push_back(t_s);
  }
  return {missing, differing};
}

// All that lie in a span are there, to the length of a period, and none that does not.
void ExpectSpan(const std::vector<double>& times_s, double from_s, double until_s, double period_s) {
  ASSERT_FALSE(times_s.empty()) << from_s;
  EXPECT_GE(times_s.front(), from_s - 1e-9);
  EXPECT_LE(times_s.back(), until_s + 0.004 + 1e-9);  // of the message that tells it
  EXPECT_GE(static_cast<double>(times_s.size()), (until_s - from_s) / period_s - 1);
}

TEST(Px4Physics, FaultsOfGpsBarometerAndCompassReachTheAutopilot) {
  SensorFault gps = Fault("gps", "wrong", 2.5, 3.5), baro = Fault("baro", "wrong", 1.1, 2.1),
              mag = Fault("mag", "wrong", 0.7, 1.7);
  gps.gps_offset_m = {7, -4, -3}, gps.gps_offset_m_s = {0.5, 0, -0.25};
  baro.barometer_offset_m = 8;
  mag.magnetometer_offset_ut = {0, 12, 0};
  const Heard sound = Listen({});
  const Heard faulty = Listen({Fault("gps", "off", 1, 2), gps, baro, Fault("baro", "off", 2.6, 3.4), mag,
                               Fault("mag", "off", 2.2, 3)});
  ASSERT_GT(sound.fixes.size(), 15U);
  ASSERT_GT(sound.pressures.size(), 50U);
  ASSERT_GT(sound.fields.size(), 50U);

  const auto [no_fix, other_fix] =
      Compare(sound.fixes, faulty.fixes, [](const mav::HilGps& a, const mav::HilGps& b) {
        return a.lat != b.lat || a.lon != b.lon || a.alt != b.alt || a.vn != b.vn || a.vd != b.vd;
      });
  ExpectSpan(no_fix, 1, 2, 0.2);
  ExpectSpan(other_fix, 2.5, 3.5, 0.2);
  for (const double t_s : other_fix) {
    const mav::HilGps &a = sound.fixes.at(t_s), &b = faulty.fixes.at(t_s);
    EXPECT_NEAR((b.lat - a.lat) * 1e-7 * 111050, 7, 0.03);  // m in a degree of latitude, in Madrid
    EXPECT_NEAR((b.lon - a.lon) * 1e-7 * 84900, -4, 0.03);  // of longitude
    EXPECT_NEAR(b.alt - a.alt, 3000, 2);
    EXPECT_NEAR(b.vn - a.vn, 50, 1);
    EXPECT_NEAR(b.vd - a.vd, -25, 1);
  }

  const auto [no_pressure, other_pressure] = Compare(
      sound.pressures, faulty.pressures,
      [](const mav::HilSensor& a, const mav::HilSensor& b) { return a.abs_pressure != b.abs_pressure; });
  const double baro_period_s = kFlight_s / static_cast<double>(sound.pressures.size());
  ExpectSpan(no_pressure, 2.6, 3.4, baro_period_s);
  ExpectSpan(other_pressure, 1.1, 2.1, baro_period_s);
  for (const double t_s : other_pressure) {
    const mav::HilSensor &a = sound.pressures.at(t_s), &b = faulty.pressures.at(t_s);
    EXPECT_NEAR(b.pressure_alt - a.pressure_alt, 8, 0.01);
    EXPECT_NEAR((b.abs_pressure - a.abs_pressure) * 100, -8 * 1.15 * 9.80665, 2);  // rho g h
  }

  const auto [no_field, other_field] =
      Compare(sound.fields, faulty.fields, [](const mav::HilSensor& a, const mav::HilSensor& b) {
        return a.xmag != b.xmag || a.ymag != b.ymag || a.zmag != b.zmag;
      });
  const double mag_period_s = kFlight_s / static_cast<double>(sound.fields.size());
  ExpectSpan(no_field, 2.2, 3, mag_period_s);
  ExpectSpan(other_field, 0.7, 1.7, mag_period_s);
  for (const double t_s : other_field)
    EXPECT_NEAR(faulty.fields.at(t_s).ymag - sound.fields.at(t_s).ymag, 0.12, 1e-4);  // gauss
}

}  // namespace
}  // namespace kestrel::sim
