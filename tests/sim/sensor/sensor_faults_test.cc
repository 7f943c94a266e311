// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/sensor_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/diagnostics.h"
#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"
#include "sim/fault_schedule.h"
#include "sim/sensor/sensor_monitor.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kDt = 0.002;

SensorFault Fault(const char* component, const char* type, double from_s = 1, double until_s = 2) {
  SensorFault f;
  f.component = component, f.type = type, f.from_s = from_s, f.until_s = until_s;
  return f;
}

// What the sensors say at step i, different each time: inertial ones always, the others every 20 steps
// (25 Hz), the GPS every 100 (5 Hz).
SensorReadings Said(int i) {
  SensorReadings r;
  r.imu = {Vector3d(i, 2 * i, 3 * i) * 1e-6, Vector3d(1e-6 * i, 0, -9.8)};
  if (i % 20 == 0) r.height_m = i, r.field_B = Vector3d(i, -i, 1) * 1e-9;
  if (i % 100 == 0) r.gps = GpsSample{Vector3d(i, -i, 2 * i), Vector3d(0, i, 0)};
  return r;
}

// What is heard at step i of a run from 0 to three seconds.
std::vector<SensorReadings> Heard(const std::vector<SensorFault>& faults, std::uint64_t seed = 1) {
  SensorFaults channel(faults, seed);
  std::vector<SensorReadings> all;
  for (int i = 0; i < 1500; ++i) {
    all.push_back(Said(i));
    channel.Apply(i * kDt, all.back());
  }
  return all;
}

void ExpectSame(const SensorReadings& a, const SensorReadings& b) {
  EXPECT_EQ(a.imu.w_B, b.imu.w_B);
  EXPECT_EQ(a.imu.specific_force_B, b.imu.specific_force_B);
  EXPECT_EQ(a.gyro_spoke, b.gyro_spoke);
  EXPECT_EQ(a.accelerometer_spoke, b.accelerometer_spoke);
  EXPECT_EQ(a.height_m, b.height_m);
  EXPECT_EQ(a.field_B, b.field_B);
  ASSERT_EQ(a.gps.has_value(), b.gps.has_value());
  if (!a.gps) return;
  EXPECT_EQ(a.gps->p_N, b.gps->p_N);
  EXPECT_EQ(a.gps->v_N, b.gps->v_N);
}

// The steps in which a GPS was heard, and the step in which what it said was made.
std::vector<std::pair<int, int>> Fixes(const std::vector<SensorReadings>& heard) {
  std::vector<std::pair<int, int>> fixes;
  for (int i = 0; i < static_cast<int>(heard.size()); ++i)
    if (heard[i].gps) fixes.emplace_back(i, static_cast<int>(std::lround(heard[i].gps->p_N.x())));
  return fixes;
}

const std::vector<const char*> kComponents = {"gyro", "accel", "mag", "baro", "gps"};
const std::vector<const char*> kTypes = {"off",  "stuck",   "garbage",     "wrong",
                                         "slow", "delayed", "intermittent"};

TEST(SensorFaults, TouchNoOtherSensorAndNoOtherTime) {
  for (const char* component : kComponents) {
    for (const char* type : kTypes) {
      SCOPED_TRACE(std::string(component) + ' ' + type);
      const auto heard = Heard({Fault(component, type)});
      int touched = 0;
      for (int i = 0; i < 1500; ++i) {
        SensorReadings expected = Said(i);
        const SensorReadings& h = heard[i];
        if (i >= 500 && i < 1000) {  // t from 1 s, up to 2 s
          const std::string c = component;
          if (c == "gyro")
            touched += !h.gyro_spoke || h.imu.w_B != expected.imu.w_B, expected.imu.w_B = h.imu.w_B,
                                                                       expected.gyro_spoke = h.gyro_spoke;
          if (c == "accel")
            touched += !h.accelerometer_spoke || h.imu.specific_force_B != expected.imu.specific_force_B,
                expected.imu.specific_force_B = h.imu.specific_force_B,
                expected.accelerometer_spoke = h.accelerometer_spoke;
          if (c == "mag") touched += h.field_B != expected.field_B, expected.field_B = h.field_B;
          if (c == "baro") touched += h.height_m != expected.height_m, expected.height_m = h.height_m;
          if (c == "gps")
            touched +=
                h.gps.has_value() != expected.gps.has_value() || (h.gps && h.gps->p_N != expected.gps->p_N),
                expected.gps = h.gps;
        }
        ExpectSame(h, expected);
      }
      EXPECT_GE(touched, 2);
    }
  }
}

TEST(SensorFaults, OffSaysNothing) {
  EXPECT_THAT(Fixes(Heard({Fault("gps", "off", 0.2, 2.6)})),
              ElementsAre(std::pair(0, 0), std::pair(1300, 1300), std::pair(1400, 1400)));
  const auto heard = Heard({Fault("gyro", "off"), Fault("accel", "off"), Fault("baro", "off")});
  for (int i = 500; i < 1000; ++i) {
    EXPECT_FALSE(heard[i].gyro_spoke || heard[i].accelerometer_spoke || heard[i].height_m);
    EXPECT_EQ(heard[i].imu.w_B, Said(499).imu.w_B);  // the last
    EXPECT_EQ(heard[i].imu.specific_force_B, Said(499).imu.specific_force_B);
  }
  // one that never said anything: at rest and level
  const auto never = Heard({Fault("gyro", "off", 0, 1), Fault("accel", "off", 0, 1)});
  EXPECT_EQ(never[0].imu.w_B, Vector3d::Zero());
  EXPECT_EQ(never[0].imu.specific_force_B, Vector3d(0, 0, -9.80665));
}

TEST(SensorFaults, StuckRepeatsTheLastReadingOrTheFirst) {
  auto heard = Heard({Fault("baro", "stuck"), Fault("gyro", "stuck")});
  for (int i = 500; i < 1000; ++i) {
    EXPECT_EQ(heard[i].height_m.has_value(), i % 20 == 0);
    EXPECT_EQ(heard[i].height_m.value_or(480), 480);
    EXPECT_TRUE(heard[i].gyro_spoke);
    EXPECT_EQ(heard[i].imu.w_B, Said(499).imu.w_B);
  }
  heard = Heard({Fault("baro", "stuck", 0, 1)});
  EXPECT_EQ(*heard[480].height_m, 0);
}

TEST(SensorFaults, GarbageFillsTheRangeOfTheSensorByTheSeed) {
  std::vector<SensorFault> all;
  for (const char* component : kComponents) all.push_back(Fault(component, "garbage", 0, 1e9));
  const SensorRanges ranges;
  SensorFaults channel(all, 3), same(all, 3), other(all, 4);
  const struct {
    const char* of;
    double low, high;
    double (*value)(const SensorReadings&);
  } quantities[] = {
      {"gyro", -Radians(ranges.gyro_deg_s), Radians(ranges.gyro_deg_s),
       [](const SensorReadings& r) { return r.imu.w_B.y(); }},
      {"accel", -ranges.accelerometer_m_s2, ranges.accelerometer_m_s2,
       [](const SensorReadings& r) { return r.imu.specific_force_B.z(); }},
      {"mag", -ranges.magnetometer_t, ranges.magnetometer_t,
       [](const SensorReadings& r) { return r.field_B->x(); }},
      {"baro", ranges.height_low_m, ranges.height_high_m,
       [](const SensorReadings& r) { return *r.height_m; }},
      {"gps", -ranges.gps_m, ranges.gps_m, [](const SensorReadings& r) { return r.gps->p_N.z(); }},
      {"gps", -ranges.gps_m_s, ranges.gps_m_s, [](const SensorReadings& r) { return r.gps->v_N.x(); }},
  };
  constexpr int kSamples = 20000;
  std::vector<std::vector<double>> shares(std::size(quantities));  // 0 to 1 of the range
  for (int i = 0; i < kSamples; ++i) {
    SensorReadings r = Said(0), s = Said(0), o = Said(0);
    channel.Apply(i * kDt, r), same.Apply(i * kDt, s), other.Apply(i * kDt, o);
    ExpectSame(r, s);
    EXPECT_NE(r.imu.w_B, o.imu.w_B);
    for (std::size_t k = 0; k < std::size(quantities); ++k) {
      const auto& q = quantities[k];
      shares[k].push_back((q.value(r) - q.low) / (q.high - q.low));
    }
  }
  for (std::size_t k = 0; k < shares.size(); ++k) {  // Kolmogorov and Smirnov's distance from uniform
    std::sort(shares[k].begin(), shares[k].end());
    double worst = 0;
    for (int i = 0; i < kSamples; ++i)
      worst = std::max(worst, std::abs(shares[k][i] - static_cast<double>(i) / kSamples));
    EXPECT_LT(worst, 1.95 / std::sqrt(kSamples)) << quantities[k].of;  // one in a thousand is beyond
  }
}

TEST(SensorFaults, WrongIsOffByWhatIsStated) {
  SensorFault gyro = Fault("gyro", "wrong"), accel = Fault("accel", "wrong"), mag = Fault("mag", "wrong"),
              baro = Fault("baro", "wrong"), gps = Fault("gps", "wrong");
  gyro.gyro_offset_deg_s = {10, 20, -30}, accel.accelerometer_offset_m_s2 = {1, -2, 3};
  mag.magnetometer_offset_ut = {5, 6, -7}, baro.barometer_offset_m = -12;
  gps.gps_offset_m = {3, 4, -5}, gps.gps_offset_m_s = {0.5, 0, -0.25};
  const SensorReadings h = Heard({gyro, accel, mag, baro, gps})[600], said = Said(600);
  const auto close = [](const Vector3d& a, const Vector3d& b, double tolerance) {
    EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " and " << b.transpose();
  };
  close(h.imu.w_B - said.imu.w_B, {0.174532925199, 0.349065850399, -0.523598775598}, 1e-11);
  close(h.imu.specific_force_B - said.imu.specific_force_B, {1, -2, 3}, 1e-12);
  close(*h.field_B - *said.field_B, {5e-6, 6e-6, -7e-6}, 1e-18);
  EXPECT_EQ(*h.height_m, 588);
  close(h.gps->p_N - said.gps->p_N, {3, 4, -5}, 1e-10);
  close(h.gps->v_N - said.gps->v_N, {0.5, 0, -0.25}, 1e-10);
}

TEST(SensorFaults, SlowSpeaksAtItsRateAtMost) {
  SensorFault f = Fault("gps", "slow", 0.1, 2.5);
  f.rate_hz = 2.5;
  using P = std::pair<int, int>;
  EXPECT_THAT(Fixes(Heard({f})), ElementsAre(P(0, 0), P(100, 100), P(300, 300), P(500, 500), P(700, 700),
                                             P(900, 900), P(1100, 1100), P(1300, 1300), P(1400, 1400)));
  f = Fault("gyro", "slow");
  f.rate_hz = 50;
  const auto heard = Heard({f});
  for (int i = 500; i < 1000; ++i) {
    EXPECT_EQ(heard[i].gyro_spoke, i % 10 == 0) << i;
    EXPECT_EQ(heard[i].imu.w_B, Said(i - i % 10).imu.w_B) << i;
  }
}

TEST(SensorFaults, DelayedComesLateAndNothingIsCaughtUp) {
  SensorFault f = Fault("gps", "delayed", 0.5, 2.0);
  f.delay_s = 0.3;
  using P = std::pair<int, int>;
  // made at 0.6, 0.8, ... 1.6 s; that of 1.8 s would come at 2.1 s
  EXPECT_THAT(Fixes(Heard({f})),
              ElementsAre(P(0, 0), P(100, 100), P(200, 200), P(450, 300), P(550, 400), P(650, 500),
                          P(750, 600), P(850, 700), P(950, 800), P(1000, 1000), P(1100, 1100), P(1200, 1200),
                          P(1300, 1300), P(1400, 1400)));
  f = Fault("accel", "delayed");
  f.delay_s = 0.1;
  const auto heard = Heard({f});
  for (int i = 500; i < 1000; ++i) {
    EXPECT_EQ(heard[i].accelerometer_spoke, i >= 550);
    EXPECT_EQ(heard[i].imu.specific_force_B, Said(i >= 550 ? i - 50 : 499).imu.specific_force_B);
  }
}

TEST(SensorFaults, IntermittentSpeaksInItsShareOfEachPeriod) {
  SensorFault f = Fault("baro", "intermittent", 1, 2.9);
  f.period_s = 0.4, f.duty = 0.25;
  const auto heard = Heard({f});
  for (int i = 500; i < 1450; i += 20) EXPECT_EQ(heard[i].height_m.has_value(), (i - 500) % 200 < 50) << i;
  f.duty = 0;
  for (int i = 500; i < 1450; i += 20) EXPECT_FALSE(Heard({f})[i].height_m);
}

TEST(SensorFaults, TheFirstInTheListHoldsAndOkIsNone) {
  const auto heard =
      Heard({Fault("baro", "ok", 1.2, 1.4), Fault("baro", "off", 1, 1.6), Fault("baro", "wrong", 0.9, 2)});
  const auto at = [&](double t_s) {
    return heard[static_cast<std::size_t>(std::lround(t_s / kDt))].height_m;
  };
  EXPECT_EQ(*at(0.92), 470);
  EXPECT_FALSE(at(1.0) || at(1.16));
  EXPECT_EQ(*at(1.2), 600);
  EXPECT_EQ(*at(1.36), 680);
  EXPECT_FALSE(at(1.4));
  EXPECT_EQ(*at(1.6), 810);
  EXPECT_EQ(*at(2.0), 1000);
}

TEST(FaultSchedule, SaysEveryChangeInTheOrderOfTime) {
  ActuatorFault motor;
  motor.component = "motor", motor.type = "off", motor.instance = 2, motor.from_s = 3, motor.until_s = 5;
  ActuatorFault all = motor;
  all.type = "slow", all.instance = 0, all.from_s = 4, all.until_s = 6;
  std::vector<std::string> said;
  for (const StateChange& c :
       ChangesOf({Fault("gps", "off", 2, 4), Fault("gps", "slow", 3, 6), Fault("mag", "ok", 1, 9)},
                 {motor, all}, MultirotorParameters{}))
    said.push_back(std::to_string(std::lround(c.t_s)) + ' ' + c.what + ' ' + c.is);
  EXPECT_THAT(said, ElementsAre("2 gps off", "3 motor 2 off", "4 gps slow", "4 motor 1 slow",
                                "4 motor 3 slow", "4 motor 4 slow", "5 motor 2 slow", "6 gps ok",
                                "6 motor 1 ok", "6 motor 2 ok", "6 motor 3 ok", "6 motor 4 ok"));
}

std::vector<std::string> Refusals(const char* yaml, const AirframeParameters& aircraft) {
  struct Keys {
    SensorParameters sensors;
    ActuatorParameters actuators;
  } keys;
  Mistakes mistakes;
  const Config config = ParseConfig(yaml, "f.yaml", {}, mistakes);
  FieldReader reader(config.root, "", mistakes);
  reader("sensors", keys.sensors), reader("actuators", keys.actuators);
  reader.Finish();
  CheckFaults(keys.sensors, keys.actuators, aircraft, "f.yaml", "f.yaml", mistakes);
  return mistakes.Texts();
}

TEST(FaultSchedule, RefusesWhatMakesNoSenseAllAtOnce) {
  EXPECT_THAT(Refusals(R"(
sensors: {faults: [{component: gps, type: 'off', from_s: 20, until_s: 40},
                   {component: baro, type: wrong, offset_m: -20}, {component: gyro, type: slow, rate_hz: 20}]}
actuators: {faults: [{component: motor, type: wrong, instance: 4, loss: 0.2}]})",
                       MultirotorParameters{}),
              IsEmpty());
  const auto refusals = Refusals(R"(
sensors: {faults: [{component: airspeed, type: stuck}, {component: gps, type: broken},
                   {component: mag, type: stuck, delay_s: 1}, {component: gps, type: slow, rate_hz: 5},
                   {component: baro, type: stuck, from_s: 4, until_s: 3}]}
actuators: {faults: [{component: servo, type: stuck}, {component: motor, type: garbage},
                     {component: motor, type: wrong, offset_deg: 3},
                     {component: motor, type: 'off', from_s: 4, until_s: 4}]})",
                                 MultirotorParameters{});
  EXPECT_THAT(refusals,
              ElementsAre(HasSubstr("sensors.faults.0.component"), HasSubstr("sensors.faults.1.type"),
                          HasSubstr("sensors.faults.2.delay_s"), HasSubstr("actuators.faults.1.type"),
                          HasSubstr("actuators.faults.2.offset_deg"), HasSubstr("sensors.faults.4.until_s"),
                          HasSubstr("sensors.faults.3.rate_hz"), HasSubstr("actuators.faults.3.until_s"),
                          HasSubstr("actuators.faults.0.component")));
  EXPECT_THAT(Refusals("actuators: {faults: [{component: servo, type: stuck, instance: 4},"
                       "{component: motor, type: 'off', instance: 2}]}",
                       HelicopterParameters{}),
              ElementsAre(HasSubstr("actuators.faults.1.instance: there is no motor 2")));
}

// What the autopilot calls its sensors in the end of 3 s with a fault from 1 s on.
std::string Called(const char* component, const char* type) {
  SensorMonitor watch((SensorParameters()));
  SensorFault f = Fault(component, type, 0.5, 1e9);
  f.rate_hz = 0.1, f.delay_s = 10;
  for (const SensorReadings& r : Heard({f})) watch.Step(kDt, r);
  return NameOf(watch.health());
}

TEST(SensorWatch, NamesSensorsThatAreSilentOrStuck) {
  for (const char* type : {"off", "slow", "delayed"}) {
    EXPECT_EQ(Called("gyro", type), "gyro silent: rates as last received");
    EXPECT_EQ(Called("accel", type), "accel silent: forces as last received");
    EXPECT_EQ(Called("baro", type), "baro silent: height by gps");
    EXPECT_EQ(Called("gps", type), "gps silent: dead reckoning");
    EXPECT_EQ(Called("mag", type), "mag silent: heading by gyro");
  }
  EXPECT_EQ(Called("gyro", "stuck"), "gyro stuck: rates as last received");
  EXPECT_EQ(Called("gps", "stuck"), "gps stuck: dead reckoning");
  EXPECT_EQ(Called("baro", "stuck"), "baro stuck: height by gps");
  for (const char* component : kComponents) {
    EXPECT_EQ(Called(component, "ok"), "ok");
    EXPECT_EQ(Called(component, "wrong"), "ok");
    EXPECT_EQ(Called(component, "garbage"), "ok");
  }
}

}  // namespace
}  // namespace kestrel::sim
