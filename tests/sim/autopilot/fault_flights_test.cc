// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>

#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"
#include "sim/autopilot/emulated_autopilot.h"
#include "sim/fault_schedule.h"
#include "sim/sensor/sensor_faults.h"
#include "sim/vehicle_file.h"
#include "sim/world/frames.h"
#include "sim/world/mjcf.h"
#include "sim/world/wind.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;

constexpr double kDt = 0.002, kGravity = 9.80665, kHeight_m = 30;

const std::filesystem::path kVehicles = std::filesystem::path(KESTREL_SOURCE_DIR) / "models" / "vehicles";

// Of the Pelican: the defaults.
VehicleFile VehicleOf(const std::string& name) {
  VehicleFile vehicle;
  if (name == "pelican") return vehicle;
  Mistakes mistakes;
  Read(LoadConfig(kVehicles / name / (name + ".yaml"), {}, mistakes), vehicle, mistakes);
  mistakes.ThrowIfAny();
  return vehicle;
}

ModelPtr OverAPlane(const std::string& name) {
  CompiledModel compiled =
      CompileMjcf(R"(<mujoco><option timestep="0.002" gravity="0 0 -9.80665"/><worldbody>
      <geom type="plane" size="1000 1000 1"/><include file=")" +
                  (kVehicles / name / (name + ".xml")).string() + R"("/></worldbody></mujoco>)");
  EXPECT_TRUE(compiled.model) << compiled.message;
  return std::move(compiled.model);
}

SensorFault Fault(const char* component, const char* type, double from_s = 15, double until_s = 1e9) {
  SensorFault f;
  f.component = component, f.type = type, f.from_s = from_s, f.until_s = until_s;
  return f;
}
ActuatorFault Fails(const char* component, const char* type, int instance) {
  ActuatorFault f;
  f.component = component, f.type = type, f.instance = instance, f.from_s = 15;
  return f;
}

// Holding a place 30 m up in a breeze, with the published sensors and their faults.
class Flight {
 public:
  Flight(const std::string& name, std::uint64_t seed, const std::vector<SensorFault>& sensor_faults,
         const std::vector<ActuatorFault>& actuator_faults = {})
      : what_(VehicleOf(name)),
        model_(OverAPlane(name)),
        data_(mj_makeData(model_.get())),
        airframe_(MakeAirframe(what_.airframe, model_.get(), true)),
        wind_(Breeze(), seed),
        sensors_({}, seed),
        faults_(sensor_faults, seed),
        actuator_faults_(actuator_faults),
        autopilot(what_.autopilot, {}, what_.airframe, Start(), true, GyroBias()) {
    PoseToMujoco(Start(), data_->qpos);
    mj_forward(model_.get(), data_.get());
  }

  void Run(double duration_s, auto each) {
    for (const double end = t_s + duration_s - kDt / 2; t_s < end;) Step(), each();
  }
  void Run(double duration_s) {
    Run(duration_s, [] {});
  }

  Pose X_NB() const { return PoseFromMujoco(data_->qpos); }
  Vector3d v_N() const { return VectorFromMujoco(data_->qvel); }
  double Away() const { return (X_NB().p - Start().p).head<2>().norm(); }
  double Height() const { return -X_NB().p.z(); }
  double YawErrorDeg() const { return Degrees(WrapAngle(YawOf(autopilot.State().R_NB) - YawOf(X_NB().R))); }
  std::string Named() const { return NameOf(autopilot.Health()); }

  double t_s = 0;
  bool crashed = false, finite = true;
  std::set<std::string> names;  // that the navigation had

 private:
  static Pose Start() { return {HeadingRotation(Radians(40)), {0, 0, -kHeight_m}}; }
  static WindParameters Breeze() {
    WindParameters w;
    w.mean_m_s = 3, w.from_deg = 200, w.turbulence = true;
    return w;
  }
  Vector3d GyroBias() const {  // as averaged at rest before the flight
    Sensors at_rest = sensors_;
    Vector3d bias = Vector3d::Zero();
    for (int i = 0; i < 1000; ++i)
      bias +=
          at_rest.Read(kDt, Start(), Vector3d::Zero(), Vector3d::Zero(), {0, 0, -kGravity}).imu.w_B / 1000;
    return bias;
  }

  void Step() {
    const Vector3d before = v_N();
    wind_.Step(kDt, Height(), before);
    SetConditions(airframe_, ConditionsAt(actuator_faults_, t_s));
    Apply(airframe_, data_.get(), kDt, wind_.Velocity(), 0);
    mj_step(model_.get(), data_.get());
    t_s += kDt;
    const Vector3d force_B = X_NB().R.conjugate() * ((v_N() - before) / kDt - Vector3d(0, 0, kGravity));
    SensorReadings readings = sensors_.Read(kDt, X_NB(), v_N(), VectorFromMujoco(data_->qvel + 3), force_B);
    Disturb(airframe_, readings);
    faults_.Apply(t_s, readings);
    Command(airframe_, autopilot.Step(kDt, readings));
    crashed = crashed || data_->ncon > 0;
    finite = finite && control::Finite(autopilot.State()) && X_NB().p.allFinite() && v_N().allFinite();
    if (autopilot.Health() != health_) health_ = autopilot.Health(), names.insert(NameOf(health_));
  }

  VehicleFile what_;
  ModelPtr model_;
  DataPtr data_;
  Airframe airframe_;
  Wind wind_;
  Sensors sensors_;
  SensorFaults faults_;
  std::vector<ActuatorFault> actuator_faults_;
  NavigationHealth health_;

 public:
  EmulatedAutopilot autopilot;
};

TEST(FaultFlights, WithoutFaultsNothingIsRefused) {
  for (const char* vehicle : {"pelican", "sr20"}) {
    Flight flight(vehicle, 1, {});
    flight.Run(30);
    EXPECT_TRUE(flight.names.empty()) << vehicle << ' ' << *flight.names.begin();
  }
}

// 20 s on the IMU: the gyroscopes' noise, averaged for two seconds before the flight, leaves 2.4e-4 rad/s,
// which makes g T^3 / 6 of 3 m; the accelerometers' walk sqrt(T^5 / 20) of 2.4 m; a tilt and a velocity that
// were off by 0.1 deg and 0.1 m/s at its beginning 3.5 and 2 m: 6 m in all, and 20 m are more than three of
// these deviations.
TEST(FaultFlights, WithoutGpsItDriftsAndRecovers) {
  double farthest = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Flight flight("pelican", seed, {Fault("gps", "off", 15, 35)});
    flight.Run(15.1);
    flight.Run(18.9, [&] { farthest = std::max(farthest, flight.Away()); });
    EXPECT_EQ(flight.Named(), "gps silent: dead reckoning");
    EXPECT_LT(flight.Away(), 20) << seed;
    EXPECT_NEAR(flight.Height(), kHeight_m, 3) << seed;  // by the barometer
    flight.Run(30);
    EXPECT_LT(flight.Away(), 7) << seed;  // that is where a GPS of 2.1 m says it should be
    EXPECT_EQ(flight.Named(), "ok");
    EXPECT_TRUE(flight.finite && !flight.crashed);
  }
  EXPECT_GT(farthest, 1);  // it is no truth in disguise
  RecordProperty("farthest_m", std::to_string(farthest));
}

TEST(FaultFlights, WithoutABarometerItHasItsHeightByGps) {
  Flight flight("pelican", 2, {Fault("baro", "off")});
  flight.Run(45);
  EXPECT_EQ(flight.Named(), "baro silent: height by gps");
  EXPECT_NEAR(flight.Height(), kHeight_m, 6);
}

TEST(FaultFlights, ABarometerThatJumpsIsRefusedWhileGpsContradictsIt) {
  SensorFault f = Fault("baro", "wrong");
  f.barometer_offset_m = 20;
  Flight flight("pelican", 3, {f});
  flight.Run(35, [&] { ASSERT_NEAR(flight.Height(), kHeight_m, 4); });
  EXPECT_EQ(flight.Named(), "baro refused: height by gps");
}

TEST(FaultFlights, GarbageOfOneAidIsRefused) {
  const std::pair<const char*, const char*> cases[] = {{"gps", "gps refused: dead reckoning"},
                                                       {"baro", "baro refused: height by gps"},
                                                       {"mag", "mag refused: heading by gyro"}};
  for (const auto& [component, name] : cases) {
    Flight flight("pelican", 4, {Fault(component, "garbage", 15, 19)});
    flight.Run(40, [&] { ASSERT_LT(flight.Away(), 8) << component << ' ' << flight.t_s; });
    EXPECT_THAT(flight.names, Contains(name));
    EXPECT_EQ(flight.Named(), "ok") << component;
    EXPECT_TRUE(flight.finite && !flight.crashed) << component;
  }
}

TEST(FaultFlights, AGpsThatJumpsIsBelievedInTheEnd) {
  SensorFault f = Fault("gps", "wrong");
  f.gps_offset_m = {0, 30, 0};
  Flight flight("pelican", 5, {f});
  flight.Run(19.8);
  EXPECT_LT(flight.Away(), 4);
  EXPECT_EQ(flight.Named(), "gps refused: dead reckoning");
  flight.Run(30);
  EXPECT_NEAR((flight.X_NB().p - Vector3d(0, -30, -kHeight_m)).head<2>().norm(), 0, 5);
  EXPECT_EQ(flight.Named(), "ok");
}

TEST(FaultFlights, AWrongCompassTurnsTheHeadingButNotAtOnce) {
  SensorFault small = Fault("mag", "wrong"), large = small;
  small.magnetometer_offset_ut = {0, 4, 0};
  large.magnetometer_offset_ut = {0, 40, 0};
  Flight follows("pelican", 6, {small});
  follows.Run(35);
  EXPECT_GT(std::abs(follows.YawErrorDeg()), 4);  // atan(4 / 25.5) is 9 degrees, by its heading
  EXPECT_LT(std::abs(follows.YawErrorDeg()), 14);
  EXPECT_TRUE(follows.names.empty());

  Flight refuses("pelican", 6, {large});
  refuses.Run(15);
  const double before = refuses.YawErrorDeg();
  refuses.Run(4.9, [&] { ASSERT_NEAR(refuses.YawErrorDeg(), before, 3); });
  EXPECT_EQ(refuses.Named(), "mag refused: heading by gyro");
  refuses.Run(3);
  EXPECT_GT(std::abs(refuses.YawErrorDeg()), 30);
  EXPECT_THAT(refuses.names, Contains("ok"));  // for a time, until the aircraft turns under the field
  refuses.Run(15);
  EXPECT_TRUE(refuses.finite);
}

TEST(FaultFlights, WithoutItsGyroscopesItIsLostAndSaysSo) {
  const std::pair<const char*, const char*> cases[] = {{"stuck", "gyro stuck: rates as last received"},
                                                       {"off", "gyro silent: rates as last received"}};
  for (const auto& [type, name] : cases) {
    Flight flight("pelican", 7, {Fault("gyro", type)});
    flight.Run(45);
    EXPECT_TRUE(flight.finite) << type;
    EXPECT_TRUE(flight.crashed) << type;
    bool named = false;
    for (const std::string& n : flight.names) named = named || n.starts_with(name);
    EXPECT_TRUE(named) << type;
  }
}

TEST(FaultFlights, WhateverFailsItsNumbersStayNumbers) {
  for (const char* component : {"gyro", "accel", "mag", "baro", "gps"}) {
    for (const char* type : {"off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent"}) {
      Flight flight("pelican", 8, {Fault(component, type, 1, 9)});
      flight.Run(12);
      EXPECT_TRUE(flight.finite) << component << ' ' << type;
    }
  }
  std::vector<SensorFault> all;
  for (const char* component : {"gyro", "accel", "mag", "baro", "gps"})
    all.push_back(Fault(component, "garbage", 1, 30));
  for (const char* vehicle : {"pelican", "sr20"}) {
    Flight flight(vehicle, 9, all);
    flight.Run(40);
    EXPECT_TRUE(flight.finite) << vehicle;
  }
}

TEST(FaultFlights, AQuadrotorWithoutAMotorCrashes) {
  Flight flight("pelican", 10, {}, {Fails("motor", "off", 2)});
  flight.Run(30);
  EXPECT_TRUE(flight.finite);
  EXPECT_TRUE(flight.crashed);
  for (const char* type : {"stuck", "slow"}) {
    Flight lame("pelican", 10, {}, {Fails("motor", type, 2)});
    lame.Run(25);
    EXPECT_TRUE(lame.finite) << type;
  }
}

TEST(FaultFlights, AQuadrotorCarriesATenthLessThrustOfOneMotor) {
  ActuatorFault weak = Fails("motor", "wrong", 3);
  weak.loss = 0.1;
  Flight flight("pelican", 11, {}, {weak});
  flight.Run(35);
  EXPECT_FALSE(flight.crashed);
  EXPECT_NEAR(flight.Height(), kHeight_m, 3);
}

TEST(FaultFlights, AHelicopterWithoutPowerComesDown) {
  Flight flight("sr20", 12, {}, {Fails("motor", "off", 1)});
  flight.Run(20);
  EXPECT_LT(flight.Height(), kHeight_m - 5);
  flight.Run(10);
  EXPECT_TRUE(flight.finite && flight.crashed);
}

TEST(FaultFlights, AHelicoptersServosFailWithoutANumberThatIsNone) {
  for (int servo = 1; servo <= 4; ++servo) {
    for (const char* type : {"off", "stuck", "wrong", "slow"}) {
      Flight flight("sr20", 13, {}, {Fails("servo", type, servo)});
      flight.Run(22);
      EXPECT_TRUE(flight.finite) << servo << ' ' << type;
    }
  }
  ActuatorFault bent = Fails("servo", "wrong", 4);
  Flight flight("sr20", 13, {}, {bent});
  flight.Run(35);
  EXPECT_LT(std::abs(flight.YawErrorDeg()), 5);
  EXPECT_NEAR(Degrees(YawOf(flight.X_NB().R)), 40, 5);  // the gyro of the tail leans against it
  EXPECT_FALSE(flight.crashed);
}

}  // namespace
}  // namespace kestrel::sim
