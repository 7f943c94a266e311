// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/actuator_faults.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "sim/aircraft/helicopter.h"
#include "sim/aircraft/multirotor.h"
#include "sim/world/mjcf.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kDt = 0.002;

ActuatorFault Fault(const char* component, const char* type, int instance = 0) {
  ActuatorFault f;
  f.component = component, f.type = type, f.instance = instance;
  return f;
}

TEST(ActuatorFaults, HoldOfTheInstanceThatTheyNameOrOfAllTheFirstInTheList) {
  ActuatorFault one = Fault("motor", "wrong", 3), all = Fault("motor", "slow"), ok = Fault("motor", "ok", 4);
  one.from_s = 1, one.until_s = 2, one.loss = 0.25, all.from_s = 1.5, all.until_s = 3, all.slowness = 7;
  const auto at = [&](double t_s) { return ConditionsAt({one, ok, all}, t_s); };
  EXPECT_EQ(at(0.999).motors[2].loss, 0);
  EXPECT_EQ(at(1).motors[2].loss, 0.25);
  EXPECT_EQ(at(1).motors[1].loss, 0);
  EXPECT_EQ(at(1).servos[2].loss, 0);
  EXPECT_EQ(at(1.6).motors[2].loss, 0.25);
  EXPECT_EQ(at(1.6).motors[2].slowness, 1);
  EXPECT_EQ(at(1.6).motors[0].slowness, 7);
  EXPECT_EQ(at(1.6).motors[3].slowness, 1);
  EXPECT_EQ(at(2).motors[2].slowness, 7);
  EXPECT_EQ(at(3).motors[2].slowness, 1);
}

TEST(ActuatorFaults, OfAMultirotorsMotors) {
  CompiledModel compiled = CompileMjcf(R"(<mujoco><option timestep="0.002" gravity="0 0 -9.80665"/><worldbody>
      <body name="vehicle" pos="0 0 100"><freejoint/><geom size="0.1" mass="1"/></body></worldbody></mujoco>)");
  ASSERT_TRUE(compiled.model) << compiled.message;
  const ModelPtr model = std::move(compiled.model);
  const MultirotorParameters p;
  const auto speeds_after = [&](const ActuatorConditions& conditions, double time_s) {
    const DataPtr data(mj_makeData(model.get()));
    mj_forward(model.get(), data.get());
    Multirotor m(p, model.get());
    m.Command({300, 300, 300, 300});
    for (int i = 0; i < 2000; ++i) m.Apply(data.get(), kDt, Vector3d::Zero(), -1e6);
    m.SetConditions(conditions);
    m.Command({400, 400, 400, 400});
    for (int i = 0; i < std::lround(time_s / kDt); ++i) m.Apply(data.get(), kDt, Vector3d::Zero(), -1e6);
    return m.speeds();
  };
  ActuatorConditions c;
  c.motors[0].off = true, c.motors[1].stuck = true, c.motors[2].loss = 0.36;
  const RotorSpeeds speeds = speeds_after(c, 4);
  EXPECT_NEAR(speeds[0], 0, 1e-6);
  EXPECT_NEAR(speeds[1], 300, 1e-6);
  EXPECT_NEAR(speeds[2], 320, 1e-6);  // 0.64 of the thrust of 400
  EXPECT_NEAR(speeds[3], 400, 1e-6);

  ActuatorConditions slow;
  slow.motors[3].slowness = 5;
  const double tau = p.rotor.time_constant_up_s;
  const RotorSpeeds late = speeds_after(slow, 0.1);
  EXPECT_NEAR(late[0], 400 - 100 * std::exp(-0.1 / tau), 1e-6);
  EXPECT_NEAR(late[3], 400 - 100 * std::exp(-0.1 / (5 * tau)), 1e-6);
}

TEST(ActuatorFaults, OfAHelicoptersServos) {
  const HelicopterParameters p;
  const HelicopterState hover = HoverState(p);
  HelicopterControls controls{hover.collective, {0, 0}, 0, true};
  controls.collective += 0.02, controls.cyclic = {0.03, -0.01};
  const auto step = [&](const ActuatorConditions& c) {
    return StepHelicopter(p, hover, controls, Vector3d::Zero(), {0, 0, 0.2}, 1e3, kDt, c);
  };
  const auto pitches = [](const HelicopterState& s) {
    return Eigen::Vector4d(s.collective, s.cyclic.x(), s.cyclic.y(), s.tail_pitch);
  };
  const Eigen::Vector4d before = pitches(hover), sound = pitches(step({}));
  const double lag = std::exp(-kDt / p.servo_s);
  const Eigen::Vector4d asked = (sound - lag * before) / (1 - lag);
  for (int i = 0; i < 4; ++i) {
    ASSERT_GT(std::abs(asked[i] - before[i]), 1e-3) << i;
    const auto expect = [&](const ActuatorCondition& condition, double pitch) {
      ActuatorConditions c;
      c.servos[static_cast<std::size_t>(i)] = condition;
      Eigen::Vector4d expected = sound;
      expected[i] = pitch;
      EXPECT_LT((pitches(step(c)) - expected).norm(), 1e-12) << i;
    };
    ActuatorCondition off, stuck, wrong, slow;
    off.off = true, stuck.stuck = true, wrong.offset = 0.05, slow.slowness = 4;
    expect(off, lag * before[i]);
    expect(stuck, before[i]);
    expect(wrong, sound[i] + (1 - lag) * 0.05);
    const double slow_lag = std::exp(-kDt / (4 * p.servo_s));
    expect(slow, asked[i] + (before[i] - asked[i]) * slow_lag);
  }
}

TEST(ActuatorFaults, OfAHelicoptersMotor) {
  const HelicopterParameters p;
  HelicopterState hover = HoverState(p);
  hover.drive.speed_rad_s -= 1;  // so that more power is asked for
  const HelicopterControls controls = HoverControls(hover);
  const auto after = [&](const ActuatorCondition& condition, int steps) {
    ActuatorConditions c;
    c.motors[0] = condition;
    HelicopterState s = hover;
    for (int i = 0; i < steps; ++i)
      s = StepHelicopter(p, s, controls, Vector3d::Zero(), Vector3d::Zero(), 1e3, kDt, c);
    return s;
  };
  ActuatorCondition off, stuck, wrong, slow;
  off.off = true, stuck.stuck = true, wrong.loss = 0.9, slow.slowness = 10;
  EXPECT_NEAR(after(off, 500).drive.power_w, 0, 1e-3);
  EXPECT_LT(after(off, 500).drive.speed_rad_s, 0.8 * p.drive.speed_rad_s);
  EXPECT_GT(after(off, 1).tail_pitch, 0);  // its gyro goes on
  EXPECT_NEAR(after(stuck, 100).drive.power_w, hover.drive.power_w, 1e-3);
  EXPECT_NEAR(after(wrong, 1000).drive.power_w, 0.1 * p.drive.power_w, 1e-3);  // the governor asks for all
  const double rise = after({}, 1).drive.power_w - hover.drive.power_w;
  ASSERT_GT(rise, 1);
  const double share =
      (1 - std::exp(-kDt / (10 * p.drive.response_s))) / (1 - std::exp(-kDt / p.drive.response_s));
  EXPECT_NEAR(after(slow, 1).drive.power_w - hover.drive.power_w, share * rise, 1e-9);
}

}  // namespace
}  // namespace kestrel::sim
