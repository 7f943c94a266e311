// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"
#include "sim/autopilot/emulated_autopilot.h"
#include "sim/vehicle_file.h"
#include "sim/world/frames.h"
#include "sim/world/mjcf.h"
#include "tests/sim/downward_view.h"
#include "tests/sim/perfect_sensors.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kDt = 0.002, kGravity = 9.80665;
constexpr double kStandingHeight_m = 0.28;

struct Sr20 {
  HelicopterParameters airframe;
  AutopilotParameters autopilot;
};

const std::filesystem::path kVehicles = std::filesystem::path(KESTREL_SOURCE_DIR) / "models" / "vehicles";

Sr20 Read(const std::string& name) {
  Mistakes mistakes;
  VehicleFile file;
  Read(LoadConfig(kVehicles / name / (name + ".yaml"), {}, mistakes), file, mistakes);
  mistakes.ThrowIfAny();
  return {std::get<HelicopterParameters>(file.airframe), file.autopilot};
}

ModelPtr OverAPlane(const std::string& name = "sr20") {
  CompiledModel compiled =
      CompileMjcf(R"(<mujoco><option timestep="0.002" gravity="0 0 -9.80665"/><worldbody>
      <geom type="plane" size="100 100 1"/><include file=")" +
                  (kVehicles / name / (name + ".xml")).string() + R"("/></worldbody></mujoco>)");
  EXPECT_TRUE(compiled.model) << compiled.message;
  return std::move(compiled.model);
}

// Autopilot, helicopter and air in a closed loop.
class Flight {
 public:
  Flight(const Pose& X_NB, bool flying, const Sr20& what = Read("sr20"))
      : model_(OverAPlane()),
        data_(mj_makeData(model_.get())),
        helicopter_(what.airframe, model_.get(), flying),
        sensors_(PerfectSensors(), 1),
        autopilot(what.autopilot, PerfectSensors(), what.airframe, X_NB, flying, Vector3d::Zero()) {
    PoseToMujoco(X_NB, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }

  void Step() {
    const Vector3d before = v_N();
    helicopter_.Apply(data_.get(), kDt, wind_N, 0);
    mj_step(model_.get(), data_.get());
    t_s += kDt;
    const Vector3d force_B = X_NB().R.conjugate() * ((v_N() - before) / kDt - Vector3d(0, 0, kGravity));
    SensorReadings readings = sensors_.Read(kDt, X_NB(), v_N(), w_B(), force_B);
    helicopter_.Disturb(readings);
    helicopter_.Command(std::get<HelicopterControls>(autopilot.Step(kDt, readings)));
  }
  void Run(double duration_s, auto each) {
    for (const double end = t_s + duration_s - kDt / 2; t_s < end;) Step(), each();
  }
  void Run(double duration_s) {
    Run(duration_s, [] {});
  }
  void Keep(const control::Setpoint& setpoint, double duration_s, auto each) {
    int steps = 0;
    Run(duration_s, [&] {
      if (steps++ % 25 == 0) autopilot.Send(setpoint);
      each();
    });
  }
  void Keep(const control::Setpoint& setpoint, double duration_s) {
    Keep(setpoint, duration_s, [] {});
  }

  Pose X_NB() const { return PoseFromMujoco(data_->qpos); }
  Vector3d v_N() const { return VectorFromMujoco(data_->qvel); }
  Vector3d w_B() const { return VectorFromMujoco(data_->qvel + 3); }
  TaitBryan Angles() const { return TaitBryanFromRotation(X_NB().R.toRotationMatrix()); }
  bool Touching() const { return data_->ncon > 0; }
  const HelicopterState& rotors() const { return helicopter_.state(); }
  const mjData* data() const { return data_.get(); }

  double t_s = 0;
  Vector3d wind_N = Vector3d::Zero();

 private:
  ModelPtr model_;
  DataPtr data_;
  Helicopter helicopter_;
  Sensors sensors_;

 public:
  EmulatedAutopilot autopilot;
};

Pose At(double height_m, double yaw_deg = 0) {
  return {HeadingRotation(Radians(yaw_deg)), {0, 0, -height_m}};
}

double HoverThrust(const HelicopterParameters& p) {
  return p.mass_kg * kGravity / MaxThrust(p.rotor, p.drive.speed_rad_s);
}

TEST(HelicopterModels, DefaultsAreThoseOfTheSr20) {
  EXPECT_EQ(ToYaml(Read("sr20").airframe), ToYaml(HelicopterParameters{}));
}

TEST(HelicopterModels, EachStandsOnItsSkids) {
  for (const char* name : {"sr20", "sra1"}) {
    const ModelPtr model = OverAPlane(name);
    const DataPtr data(mj_makeData(model.get()));
    Helicopter helicopter(Read(name).airframe, model.get(), false);
    data->qpos[2] = 0.33;
    for (int i = 0; i < 1500; ++i)
      helicopter.Apply(data.get(), kDt, Vector3d::Zero(), 0), mj_step(model.get(), data.get());
    EXPECT_NEAR(data->qpos[2], kStandingHeight_m, 0.003) << name;
    EXPECT_LT(VectorFromMujoco(data->qvel).norm(), 1e-3) << name;
    EXPECT_NEAR(data->xmat[9 + 8], 1, 1e-4) << name;
  }
}

TEST(HelicopterModels, LeavesTheViewOfItsDownwardCameraFree) {
  const ModelPtr model = OverAPlane();
  const DataPtr data(mj_makeData(model.get()));
  mj_forward(model.get(), data.get());
  ExpectFreeDownwardView(model.get(), data.get());
}

TEST(HelicopterFlight, HoversLeaningAgainstItsTailRotor) {
  for (const bool clockwise : {true, false}) {
    Sr20 what = Read("sr20");
    what.airframe.clockwise = clockwise;
    Flight flight(At(20, 30), true, what);
    flight.Run(15);
    flight.Run(5, [&] { EXPECT_LT((flight.X_NB().p - Vector3d(0, 0, -20)).norm(), 0.1); });
    // the weight's part across carries the tail's thrust, less what the tilted disc gives of its own
    const HelicopterLoads loads =
        LoadsOf(what.airframe, flight.rotors(), Vector3d::Zero(), Vector3d::Zero(), 1e6);
    const double side =
        (clockwise ? 1 : -1) * loads.tail.thrust_n - loads.rotor.thrust_n * flight.rotors().flapping.disc.y();
    EXPECT_NEAR(flight.Angles().roll, std::asin(side / (what.airframe.mass_kg * kGravity)), Radians(0.2));
    EXPECT_GT(flight.Angles().roll * (clockwise ? 1 : -1), Radians(3));
    EXPECT_NEAR(Degrees(flight.Angles().pitch), 0, 0.5);
    EXPECT_NEAR(Degrees(flight.Angles().yaw), 30, 1);
    EXPECT_NEAR(flight.rotors().drive.speed_rad_s, what.airframe.drive.speed_rad_s, 0.5);
  }
}

TEST(HelicopterFlight, RollAndPitchAnswerAsTheAutopilotIsTuned) {
  const Sr20 what = Read("sr20");
  const double thrust = HoverThrust(what.airframe);
  for (const bool rolls : {true, false}) {
    Flight flight(At(60, 30), true, what);
    flight.Run(8);
    const double level = flight.Angles().roll;
    flight.Keep(control::AttitudeSetpoint{level, 0, 0, thrust}, 2);
    const double roll = flight.Angles().roll, pitch = flight.Angles().pitch;
    double worst = 0, angle = 0, rate = 0, across = 0;  // of the second-order loop that it should be
    const AxisLoop loop = rolls ? what.autopilot.roll : what.autopilot.pitch;
    flight.Keep(control::AttitudeSetpoint{level + (rolls ? 0.15 : 0), rolls ? 0 : 0.15, 0, thrust}, 1.5, [&] {
      const double w = loop.natural_frequency_rad_s;
      rate += kDt * (w * w * (0.15 - angle) - 2 * loop.damping * w * rate), angle += kDt * rate;
      const double e_roll = flight.Angles().roll - roll, e_pitch = flight.Angles().pitch - pitch;
      worst = std::max(worst, std::abs((rolls ? e_roll : e_pitch) - angle));
      across = std::max(across, std::abs(rolls ? e_pitch : e_roll));
    });
    EXPECT_LT(worst, 0.2 * 0.15) << rolls;
    EXPECT_LT(across, 0.15 * 0.15) << rolls;
  }
}

TEST(HelicopterFlight, FliesTheVelocityAndTheTurnThatItIsAskedFor) {
  Flight flight(At(30, 90), true);
  flight.Run(5);
  flight.Keep(control::VelocitySetpoint{{1, -0.5, -0.5}, 0}, 8);
  EXPECT_LT((flight.v_N() - Vector3d(0.5, 1, -0.5)).norm(), 0.1);
  flight.Keep(control::VelocitySetpoint{{0, 0, 0}, 0.5}, 4);
  EXPECT_NEAR(flight.w_B().z(), 0.5, 0.05);
}

TEST(HelicopterFlight, TakesOffOnceItsRotorTurnsAndLandsWithoutStoppingInTheAir) {
  Flight flight(At(kStandingHeight_m, 25), false);
  flight.Run(0.5);
  flight.autopilot.Send(control::PositionSetpoint{{0, 0, -2}, Radians(25)});
  flight.Run(2, [&] { ASSERT_LT((flight.X_NB().p - Vector3d(0, 0, -kStandingHeight_m)).norm(), 0.02); });
  flight.Run(14);
  EXPECT_LT((flight.X_NB().p - Vector3d(0, 0, -2)).norm(), 0.2);
  EXPECT_NEAR(Degrees(flight.Angles().yaw), 25, 2);

  double touched_s = -1, stopped_s = -1, sink = 0;
  flight.Keep(control::VelocitySetpoint{{0, 0, 0.25}, 0}, 14, [&] {
    if (touched_s < 0 && flight.Touching()) touched_s = flight.t_s;
    if (touched_s < 0) sink = flight.v_N().z();
    if (stopped_s < 0 && flight.autopilot.State().landed) stopped_s = flight.t_s;
    ASSERT_FALSE(flight.autopilot.State().landed && touched_s < 0);
  });
  ASSERT_GT(touched_s, 0);
  EXPECT_GT(stopped_s, touched_s);
  EXPECT_LT(stopped_s - touched_s, 2);
  EXPECT_GT(sink, 0.1);
  EXPECT_LT(sink, 0.35);
  EXPECT_LT(Degrees(std::hypot(flight.Angles().roll, flight.Angles().pitch)), 0.5);
  EXPECT_LT(flight.rotors().drive.power_w, 1);
}

TEST(HelicopterFlight, AStepOfVelocityIsFlownWithoutOvershoot) {
  for (const Vector3d& v_H : {Vector3d(1, 0, 0), Vector3d(0, -1, 0)}) {
    Flight flight(At(30), true);
    flight.Run(12);
    double greatest = 0, across = 0;
    flight.Keep(control::VelocitySetpoint{v_H, 0}, 6, [&] {
      greatest = std::max(greatest, flight.v_N().dot(v_H));
      across = std::max(across, std::abs(flight.v_N().cross(v_H).z()));
    });
    EXPECT_NEAR(flight.v_N().dot(v_H), 1, 0.05);
    EXPECT_LT(greatest, 1.1);
    EXPECT_LT(across, 0.1);
  }
}

TEST(HelicopterFlight, LiftsOffWithItsHeadingHeld) {
  Flight flight(At(kStandingHeight_m, 25), false);
  flight.Run(0.5);
  flight.autopilot.Send(control::PositionSetpoint{{0, 0, -2}, Radians(25)});
  double turned = 0, carried_off = 0;
  flight.Run(12, [&] {
    turned = std::max(turned, std::abs(WrapAngle(flight.Angles().yaw - Radians(25))));
    carried_off = std::max(carried_off, flight.X_NB().p.head<2>().norm());
  });
  EXPECT_LT(flight.X_NB().p.z(), -1.8);
  EXPECT_LT(Degrees(turned), 3);
  EXPECT_LT(carried_off, 0.6);  // by the tail rotor, until it leans against it
}

// An updraught that rises faster than the loop of the climb makes up for stops the descent for a second, as
// the ground would. What tells them apart is that nothing carries the aircraft when the thrust goes.
TEST(HelicopterFlight, HeldUpByTheAirItDoesNotTakeThatForTheGround) {
  for (const double height : {1.2, 5.0}) {
    Flight flight(At(height + 0.5), true);
    flight.Run(8);
    const double start = flight.t_s;
    double slowest = 1;
    flight.Keep(control::VelocitySetpoint{{0, 0, 0.2}, 0}, 5, [&] {
      flight.wind_N.z() = -10 * std::clamp((flight.t_s - start - 2.5) / 1.5, 0.0, 1.0);
      if (flight.t_s > start + 2.5) slowest = std::min(slowest, flight.v_N().z());
      ASSERT_FALSE(flight.autopilot.State().landed && !flight.Touching()) << height;
    });
    EXPECT_LT(slowest, 0.05) << height;
  }
}

TEST(HelicopterFlight, TheSameFlightGivesTheSameBits) {
  Flight a(At(10, 30), true), b(At(10, 30), true);
  for (Flight* flight : {&a, &b}) flight->Keep(control::VelocitySetpoint{{1, 0.5, -0.2}, 0.3}, 2);
  EXPECT_EQ(std::memcmp(a.data()->qpos, b.data()->qpos, 7 * sizeof(mjtNum)), 0);
  EXPECT_EQ(std::memcmp(a.data()->qvel, b.data()->qvel, 6 * sizeof(mjtNum)), 0);
}

TEST(HelicopterFlight, TheSra1HoversToo) {
  Flight flight(At(20), true, Read("sra1"));
  flight.Run(15);
  flight.Run(3, [&] { ASSERT_LT((flight.X_NB().p - Vector3d(0, 0, -20)).norm(), 0.15); });
}

}  // namespace
}  // namespace kestrel::sim
