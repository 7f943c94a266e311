// SPDX-License-Identifier: Apache-2.0
#include "control/law/velocity_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.80665;
constexpr double kDt = 0.002;
constexpr double kCycle_s = 0.04, kDelay_s = 0.05;  // of the state on its way

// A closed attitude loop of the second order for each angle, thrust by a motor of the first order, and drag
// against moving air; what an autopilot that takes attitudes looks like from outside.
struct Aircraft {
  double hover_thrust = 0.45;  // the true one
  double drag_per_s = 0.3;
  Vector3d wind_N = Vector3d::Zero();
  double min_z = -1e9, max_z = 1e9;  // the ground is at most_z

  Vector3d p_N = Vector3d::Zero(), v_N = Vector3d::Zero();
  double roll = 0, roll_rate = 0, pitch = 0, pitch_rate = 0, yaw = 0, thrust = 0.45;

  static void Follow(double& angle, double& rate, double w, double damping, double gain, double asked) {
    rate += kDt * (w * w * (gain * asked - angle) - 2 * damping * w * rate);
    angle += kDt * rate;
  }
  void Step(const AttitudeSetpoint& asked) {
    Follow(roll, roll_rate, 7.07, 0.72, 0.80, asked.roll);
    Follow(pitch, pitch_rate, 7.07, 0.76, 0.84, asked.pitch);
    yaw += kDt * asked.yaw_rate;
    thrust += kDt / 0.05 * (asked.thrust - thrust);
    const Vector3d up_N = R_NB() * Vector3d(0, 0, -1);
    const Vector3d a_N =
        kGravity * thrust / hover_thrust * up_N + Vector3d(0, 0, kGravity) - drag_per_s * (v_N - wind_N);
    v_N += kDt * a_N;
    p_N += kDt * v_N;
    if (p_N.z() > max_z) p_N.z() = max_z, v_N.setZero();
  }
  Eigen::Quaterniond R_NB() const { return Eigen::Quaterniond(RotationFromTaitBryan({yaw, pitch, roll})); }
  double Tilt() const { return std::acos((R_NB() * Vector3d::UnitZ()).z()); }
};

struct Rig {
  Aircraft aircraft;
  VelocityLoopOptions options;
  VelocityLoopState loop;
  double t_s = 0;
  AttitudeSetpoint asked;
  bool limited = false;

  // What the loop is told is older than what is.
  void Fly(const Setpoint& setpoint, double duration_s, auto each) {
    double due_s = t_s;
    for (const double end = t_s + duration_s; t_s < end - kDt / 2; t_s += kDt) {
      VehicleState now;
      now.t_s = t_s, now.p_NB = aircraft.p_N, now.v_N = aircraft.v_N, now.R_NB = aircraft.R_NB();
      past_.push_back(now);
      if (past_.front().t_s < t_s - kDelay_s) past_.pop_front();
      if (t_s >= due_s - kDt / 2) {
        due_s += kCycle_s;
        const auto* position = std::get_if<PositionSetpoint>(&setpoint);
        const auto out = StepVelocityLoop(position ? VelocityToward(*position, past_.front(), options)
                                                   : std::get<VelocitySetpoint>(setpoint),
                                          past_.front(), loop, options);
        asked = out.setpoint, loop = out.state, limited = out.limited;
      }
      aircraft.Step(asked);
      each();
    }
  }
  void Fly(const Setpoint& setpoint, double duration_s) {
    Fly(setpoint, duration_s, [] {});
  }

 private:
  std::deque<VehicleState> past_;
};

TEST(VelocityLoop, SettlesOnAVelocityOfTheHeadingFrame) {
  const Vector3d velocities[] = {{1, 0, 0}, {0, 1, 0}, {-0.7, 0.9, 0.4}, {0, 0, -0.8}};
  for (const Vector3d& v_H : velocities) {
    for (const double yaw : {0.0, 2.0, -1.0}) {
      Rig rig;
      rig.aircraft.yaw = yaw;
      double greatest = 0;
      rig.Fly(VelocitySetpoint{v_H, 0}, 8,
              [&] { greatest = std::max(greatest, rig.aircraft.v_N.norm() / v_H.norm()); });
      EXPECT_LT((rig.aircraft.v_N - HeadingRotation(yaw) * v_H).norm(), 0.02) << v_H.transpose();
      EXPECT_LT(greatest, 1.2) << v_H.transpose();
      EXPECT_FALSE(rig.limited);
    }
  }
}

TEST(VelocityLoop, LeavesNoErrorInWindNorByAWrongHoverThrust) {
  for (const double hover : {0.30, 0.45, 0.60}) {
    Rig rig;
    rig.aircraft.hover_thrust = hover;
    rig.aircraft.wind_N = {-4, 3, 0.5};
    const Vector3d place(2, -1, -5);
    rig.Fly(PositionSetpoint{place, 0.5}, 25);
    EXPECT_LT((rig.aircraft.p_N - place).norm(), 0.02) << hover;
    EXPECT_LT(rig.aircraft.v_N.norm(), 0.02) << hover;
    EXPECT_NEAR(rig.aircraft.yaw, 0.5, 0.01);
    EXPECT_NEAR(rig.asked.thrust, hover, 0.05);  // it leans, and the air goes down
    EXPECT_GT(rig.aircraft.Tilt(), 0.05);
  }
}

TEST(VelocityLoop, KeepsItsLimits) {
  Rig rig;
  rig.aircraft.wind_N = {-3, 0, 0};
  double speed = 0, climb = 0, fastest_change = 0;
  Vector3d before = Vector3d::Zero();
  const auto watch = [&] {
    const double cos_limit = std::cos(Radians(rig.options.tilt_limit_deg));
    EXPECT_LE(std::abs(rig.asked.roll) * rig.options.roll_gain, std::acos(cos_limit) + 1e-9);
    EXPECT_LE(std::abs(rig.asked.pitch) * rig.options.pitch_gain, std::acos(cos_limit) + 1e-9);
    EXPECT_GE(rig.asked.thrust, rig.options.thrust_min);
    EXPECT_LE(rig.asked.thrust, rig.options.thrust_max);
    EXPECT_LE(std::abs(rig.asked.yaw_rate), Radians(rig.options.yaw_rate_limit_deg_s) + 1e-12);
    EXPECT_LE(rig.loop.command_N.head<2>().norm(), rig.options.speed_limit_m_s + 1e-9);
    fastest_change = std::max(fastest_change, (rig.loop.command_N - before).head<2>().norm());
    before = rig.loop.command_N;
    speed = std::max(speed, rig.aircraft.v_N.head<2>().norm());
    climb = std::max(climb, std::abs(rig.aircraft.v_N.z()));
  };
  rig.Fly(VelocitySetpoint{{40, -30, 20}, 9}, 6, watch);
  rig.Fly(PositionSetpoint{{-500, 500, -900}, 3}, 6, watch);
  EXPECT_GT(speed, 0.95 * rig.options.speed_limit_m_s);
  EXPECT_LT(speed, 1.2 * rig.options.speed_limit_m_s);
  EXPECT_GT(climb, 0.95 * rig.options.climb_limit_m_s);
  EXPECT_LT(climb, 1.2 * rig.options.climb_limit_m_s);
  EXPECT_NEAR(fastest_change, rig.options.acceleration_limit_m_s2 * kCycle_s, 1e-9);
}

// Held against its limits for a minute by wind that is too strong and a battery that is too weak, and then
// let go: a loop that had wound up would shoot over for many seconds.
TEST(VelocityLoop, DoesNotWindUpAgainstItsLimits) {
  for (const double held_s : {5.0, 60.0}) {
    Rig rig;
    rig.options.tilt_limit_deg = 8;
    rig.aircraft.wind_N = {-12, 0, 0};
    rig.aircraft.hover_thrust = 0.95;
    rig.Fly(VelocitySetpoint{}, held_s);
    EXPECT_TRUE(rig.limited);
    EXPECT_GT(rig.aircraft.v_N.z(), 0.5);
    EXPECT_LT(rig.aircraft.v_N.x(), -1);
    rig.aircraft.wind_N.setZero();
    rig.aircraft.hover_thrust = 0.45;
    rig.aircraft.v_N.setZero();
    double worst = 0;
    rig.Fly(VelocitySetpoint{}, 10, [&] { worst = std::max(worst, rig.aircraft.v_N.norm()); });
    EXPECT_LT(worst, 3) << held_s;
    EXPECT_LT(rig.aircraft.v_N.norm(), 0.1) << held_s;
  }
}

TEST(VelocityLoop, BeginsAtTheVelocityThatThereIsAndKeepsTheIntegralOverAPause) {
  VehicleState vehicle;
  vehicle.t_s = 10, vehicle.v_N = {1.5, -0.5, 0.2};
  VelocityLoopState before;
  before.t_s = 9, before.integral_N = {0.3, 0.2, -0.1};
  const auto out = StepVelocityLoop({{1.5, -0.5, 0.2}, 0}, vehicle, before, {});
  EXPECT_EQ(out.state.command_N, vehicle.v_N);
  EXPECT_EQ(out.state.integral_N, before.integral_N);
  EXPECT_NEAR(out.setpoint.pitch, -std::atan(0.3 / kGravity) / 0.84, 1e-9);
  EXPECT_NEAR(out.setpoint.thrust, 0.45 * (kGravity + 0.1) / kGravity, 1e-9);
  // The same state again changes nothing.
  const auto again = StepVelocityLoop({{1.5, -0.5, 0.2}, 0}, vehicle, out.state, {});
  EXPECT_EQ(again.state.integral_N, out.state.integral_N);
  EXPECT_EQ(again.setpoint.thrust, out.setpoint.thrust);
}

TEST(TouchDown, IsNoticedOnTheGroundAndNotInTheAir) {
  Rig rig;
  rig.aircraft.max_z = 0;
  rig.aircraft.p_N.z() = -1;
  TouchDown touch;
  double touched_s = -1, down_s = -1;
  while (down_s < 0 && rig.t_s < 20) {
    rig.Fly(VelocitySetpoint{{0, 0, 0.2}, 0}, kCycle_s);
    touch = WatchTouchDown(kCycle_s, rig.loop.reference_N.z(), rig.aircraft.v_N.z(), touch);
    if (touched_s < 0 && rig.aircraft.p_N.z() == 0) touched_s = rig.t_s;
    if (touch.down) down_s = rig.t_s;
    if (touched_s < 0) {
      ASSERT_EQ(touch.throttle, 1);
    }
  }
  ASSERT_GT(touched_s, 1);
  EXPECT_GT(down_s, touched_s + 0.8);
  EXPECT_LT(down_s, touched_s + 1.5);

  // Held up by an updraught for a while, it sinks as soon as its thrust is taken away.
  TouchDown held;
  for (int i = 0; i < 25; ++i) held = WatchTouchDown(kCycle_s, 0.2, 0.0, held);
  EXPECT_LT(held.throttle, 1);
  EXPECT_FALSE(held.down);
  held = WatchTouchDown(kCycle_s, 0.2, 0.4, held);
  EXPECT_EQ(held.throttle, 1);
  EXPECT_EQ(WatchTouchDown(kCycle_s, 0.0, 0.0, held).still_s, 0);
}

TEST(VelocityLoop, OptionsAreReadAndRefused) {
  Mistakes mistakes;
  VelocityLoopOptions options;
  const Config config =
      ParseConfig("{hover_thrust: 0.3, tilt_limit_deg: 90, spede_limit_m_s: 1}", "test", {}, mistakes);
  FieldReader reader(config.root, "", mistakes);
  Fields(reader, options);
  reader.Finish();
  EXPECT_EQ(options.hover_thrust, 0.3);
  EXPECT_EQ(mistakes.Texts().size(), 2u);
}

}  // namespace
}  // namespace kestrel::control
