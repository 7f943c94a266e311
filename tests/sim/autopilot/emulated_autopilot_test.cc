// SPDX-License-Identifier: Apache-2.0
#include "sim/autopilot/emulated_autopilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <string>

#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "sim/world/wind.h"
#include "tests/sim/pelican_over_a_plane.h"
#include "tests/sim/perfect_sensors.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kDt = 0.002;
constexpr double kGravity = 9.80665;
constexpr double kStandingHeight_m = 0.16;  // of the origin of B while the skids stand

struct Conditions {
  AutopilotParameters autopilot;
  SensorParameters sensors = PerfectSensors();
  WindParameters wind;
  std::uint64_t seed = 1;
};

WindParameters GustyWind() {
  WindParameters w;
  w.mean_m_s = 4, w.from_deg = 200, w.turbulence = true;
  w.gusts = {12, 3, 3};
  return w;
}

// Autopilot, aircraft and air in a closed loop.
class Flight {
 public:
  Flight(const Pose& X_NB, bool flying, const Conditions& c = {})
      : model_(PelicanOverAPlane()),
        data_(mj_makeData(model_.get())),
        vehicle_({}, model_.get()),
        wind_(c.wind, c.seed),
        sensors_(c.sensors, c.seed),
        autopilot(c.autopilot, c.sensors, MultirotorParameters{}, X_NB, flying, Vector3d::Zero()) {
    PoseToMujoco(X_NB, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }

  void Step() {
    const Vector3d before = v_N();
    wind_.Step(kDt, Height(), before);
    vehicle_.Apply(data_.get(), kDt, wind_.Velocity(), 0);
    mj_step(model_.get(), data_.get());
    t_s += kDt;
    const Vector3d force_B = X_NB().R.conjugate() * ((v_N() - before) / kDt - Vector3d(0, 0, kGravity));
    vehicle_.Command(
        std::get<RotorSpeeds>(autopilot.Step(kDt, sensors_.Read(kDt, X_NB(), v_N(), w_B(), force_B))));
  }
  // With nothing sent; with a setpoint kept up at 20 Hz. each: called after every step.
  void Run(double duration_s, auto each) {
    for (const double end = t_s + duration_s - kDt / 2; t_s < end;) Step(), each();
  }
  void Run(double duration_s) {
    Run(duration_s, [] {});
  }
  void Keep(const control::Setpoint& setpoint, double duration_s, auto each) {
    int steps = 0;
    for (const double end = t_s + duration_s - kDt / 2; t_s < end; ++steps) {
      if (steps % 25 == 0) autopilot.Send(setpoint);
      Step(), each();
    }
  }
  void Keep(const control::Setpoint& setpoint, double duration_s) {
    Keep(setpoint, duration_s, [] {});
  }

  Pose X_NB() const { return PoseFromMujoco(data_->qpos); }
  Vector3d v_N() const { return VectorFromMujoco(data_->qvel); }
  Vector3d w_B() const { return VectorFromMujoco(data_->qvel + 3); }
  TaitBryan Angles() const { return TaitBryanFromRotation(X_NB().R.toRotationMatrix()); }
  double Height() const { return -X_NB().p.z(); }
  double TiltDeg() const { return Degrees(std::acos(std::min(1.0, (X_NB().R * Vector3d::UnitZ()).z()))); }
  bool Touching() const { return data_->ncon > 0; }
  double Throttle() const {
    return *std::max_element(vehicle_.speeds().begin(), vehicle_.speeds().end()) / vehicle_.HoverSpeed();
  }
  control::FlightMode mode() const { return autopilot.State().mode; }

  double t_s = 0;

 private:
  ModelPtr model_;
  DataPtr data_;
  Multirotor vehicle_;
  Wind wind_;
  Sensors sensors_;

 public:
  EmulatedAutopilot autopilot;
};

Pose At(double height_m, double yaw_deg = 0) {
  return {HeadingRotation(Radians(yaw_deg)), {0, 0, -height_m}};
}

double HoverThrust() {
  const MultirotorParameters p;
  return p.mass_kg * kGravity / (4 * p.rotor.thrust_coefficient_n_s2 * std::pow(p.rotor.max_speed_rad_s, 2));
}

// Of w^2 / (s^2 + 2 d w s + w^2), d < 1: the answer to a step of one, and to a ramp of one a second.
double StepResponse(const AxisLoop& a, double t) {
  const double w = a.natural_frequency_rad_s, d = a.damping, wd = w * std::sqrt(1 - d * d);
  return 1 - std::exp(-d * w * t) * (std::cos(wd * t) + d * w / wd * std::sin(wd * t));
}
double RampResponse(const AxisLoop& a, double t) {
  const double w = a.natural_frequency_rad_s, d = a.damping, wd = w * std::sqrt(1 - d * d);
  return t - 2 * d / w +
         std::exp(-d * w * t) * (2 * d / w * std::cos(wd * t) + (2 * d * d - 1) / wd * std::sin(wd * t));
}

TEST(EmulatedAutopilot, RollAnswersAsIdentified) {
  for (const double command : {0.15, -0.3}) {
    Flight flight(At(60, 30), true);
    flight.Run(3);
    double worst = 0;
    const double start = flight.t_s;
    flight.Keep(control::AttitudeSetpoint{command, 0, 0, HoverThrust()}, 1.5, [&] {
      const double model = 0.80 * command * StepResponse({7.07, 0.72, 0.80}, flight.t_s - start);
      worst = std::max(worst, std::abs(flight.Angles().roll - model));
      EXPECT_LT(std::abs(flight.Angles().pitch), 0.03);
    });
    EXPECT_LT(worst, 0.05 * std::abs(command));
    EXPECT_EQ(flight.mode(), control::FlightMode::kAttitude);
    EXPECT_GT(flight.Angles().roll * command, 0);
    EXPECT_GT(flight.v_N().dot(HeadingRotation(Radians(30)) * Vector3d::UnitY()) * command,
              0);  // right wing down: right
  }
}

TEST(EmulatedAutopilot, PitchAnswersAsIdentified) {
  for (const double command : {0.2, -0.25}) {
    Flight flight(At(60, -50), true);
    flight.Run(3);
    double worst = 0;
    const double start = flight.t_s;
    flight.Keep(control::AttitudeSetpoint{0, command, 0, HoverThrust()}, 1.5, [&] {
      const double model = 0.84 * command * StepResponse({7.07, 0.76, 0.84}, flight.t_s - start);
      worst = std::max(worst, std::abs(flight.Angles().pitch - model));
    });
    EXPECT_LT(worst, 0.05 * std::abs(command));
    EXPECT_LT(flight.v_N().dot(HeadingRotation(Radians(-50)) * Vector3d::UnitX()) * command,
              0);  // nose up: backwards
  }
}

TEST(EmulatedAutopilot, YawAnswersToARateAsIdentified) {
  for (const double rate : {0.6, -0.6}) {
    Flight flight(At(60, 20), true);
    flight.Run(3);
    double worst = 0;
    const double start = flight.t_s;
    flight.Keep(control::AttitudeSetpoint{0, 0, rate, HoverThrust()}, 2, [&] {
      const double model = Radians(20) + rate * RampResponse({5.0, 0.95, 1.0}, flight.t_s - start);
      worst = std::max(worst, std::abs(flight.Angles().yaw - model));
    });
    EXPECT_LT(worst, 0.02);
  }
}

TEST(EmulatedAutopilot, ThrustIsAShareOfTheGreatest) {
  Flight flight(At(60), true);
  flight.Run(3);
  flight.Keep(control::AttitudeSetpoint{0, 0, 0, HoverThrust()}, 1);
  EXPECT_LT(std::abs(flight.v_N().z()), 0.1);
  const double start = flight.v_N().z();
  flight.Keep(control::AttitudeSetpoint{0, 0, 0, 1.2 * HoverThrust()}, 0.2);
  EXPECT_NEAR(flight.v_N().z() - start, -0.2 * kGravity * 0.2, 0.1);  // less what the motors take to spin up
}

TEST(EmulatedAutopilot, VelocityIsFlownInTheHeadingFrame) {
  const struct {
    Vector3d v_H, v_N;
  } cases[] = {{{1, 0, 0}, {0, 1, 0}},
               {{0, 1, 0}, {-1, 0, 0}},
               {{-0.5, 0.8, 0}, {-0.8, -0.5, 0}},
               {{0, 0, -0.6}, {0, 0, -0.6}}};
  for (const auto& c : cases) {
    Flight flight(At(30, 90), true);
    flight.Keep(control::VelocitySetpoint{c.v_H, 0}, 6);
    EXPECT_LT((flight.v_N() - c.v_N).norm(), 0.05) << c.v_H.transpose();
    EXPECT_NEAR(Degrees(flight.Angles().yaw), 90, 1);
    EXPECT_EQ(flight.mode(), control::FlightMode::kVelocity);
  }
}

// When half of what is asked for is flown, after it was asked for.
double HalfWay_s(const AutopilotParameters& autopilot, const control::VelocitySetpoint& asked) {
  Conditions conditions;
  conditions.autopilot = autopilot;
  Flight flight({Eigen::Quaterniond::Identity(), {0, 0, -20}}, true, conditions);
  flight.Run(2);
  const double asked_s = flight.t_s;
  std::optional<double> crossed_s;
  const auto answer = [&] {
    return asked.yaw_rate != 0 ? flight.w_B().z() / asked.yaw_rate
                               : flight.v_N().dot(asked.v_H) / asked.v_H.squaredNorm();
  };
  flight.Keep(asked, 5, [&] {
    if (!crossed_s && answer() > 0.5) crossed_s = flight.t_s - asked_s;
  });
  EXPECT_NEAR(answer(), 1, 0.1);
  return crossed_s.value_or(-1);
}

TEST(EmulatedAutopilot, AnAutopilotThatFollowsLateIsLaterByThatAndOtherwiseTheSame) {
  const struct {
    double AutopilotParameters::*delay;
    control::VelocitySetpoint asked;
  } axes[] = {{&AutopilotParameters::level_delay_s, {{0.7, 0, 0}, 0}},
              {&AutopilotParameters::climb_delay_s, {{0, 0, -1}, 0}},
              {&AutopilotParameters::yaw_delay_s, {{0, 0, 0}, 0.4}}};
  for (const auto& axis : axes) {
    const double at_once_s = HalfWay_s({}, axis.asked);
    EXPECT_GT(at_once_s, 0.05);
    AutopilotParameters late;
    late.*axis.delay = 0.85;
    EXPECT_NEAR(HalfWay_s(late, axis.asked), at_once_s + 0.85, 0.01);
  }
}

TEST(EmulatedAutopilot, AVerticalVelocityIsShapedWithinItsLimits) {
  const control::VelocitySetpoint climb{{0, 0, -1}, 0};
  AutopilotParameters shaped;
  shaped.climb_acceleration_limit_m_s2 = 1;
  EXPECT_NEAR(HalfWay_s(shaped, climb), 0.5, 0.05);  // v / a / 2, followed without a lag of its own
  shaped.climb_jerk_limit_m_s3 = 4;
  EXPECT_NEAR(HalfWay_s(shaped, climb), 0.5 + 0.125, 0.07);  // and a / j / 2
}

TEST(EmulatedAutopilot, AMassTakenWronglyIsMadeGood) {
  for (const double gain : {0.7, 1.4}) {
    Conditions conditions;
    conditions.autopilot.thrust_gain = gain;
    Flight flight(At(20), true, conditions);
    flight.Run(0.5);
    EXPECT_GT(std::abs(flight.v_N().z()), 0.05) << gain;  // the weight comes as an error
    flight.Run(20);
    EXPECT_NEAR(flight.Height(), 20, 0.05) << gain;
  }
}

TEST(EmulatedAutopilot, TheHeadingFrameTurnsWithTheAircraftClockwise) {
  Flight flight(At(30, 10), true);
  flight.Keep(control::VelocitySetpoint{{1, 0, 0}, 0.5}, 5);
  const double yaw = flight.Angles().yaw;
  EXPECT_NEAR(yaw, Radians(10) + 0.5 * (5 - 2 * 0.95 / 5.0), 0.05);
  flight.Keep(control::VelocitySetpoint{{1, 0, 0}, 0}, 4);
  const double settled = flight.Angles().yaw;
  EXPECT_GT(settled, yaw);
  EXPECT_LT((flight.v_N() - Vector3d(std::cos(settled), std::sin(settled), 0)).norm(), 0.05);
}

TEST(EmulatedAutopilot, FliesToAPositionAndHeading) {
  Flight flight(At(10, -170), true);
  const Vector3d p_N(4, -3, -12);
  flight.autopilot.Send(control::PositionSetpoint{p_N, Radians(150)});  // once: a position does not go stale
  flight.Run(15);
  EXPECT_LT((flight.X_NB().p - p_N).norm(), 0.05);
  EXPECT_NEAR(Degrees(flight.Angles().yaw), 150, 1);
  EXPECT_EQ(flight.mode(), control::FlightMode::kPosition);
}

TEST(EmulatedAutopilot, TurnsTheShortWayRound) {
  Flight flight(At(10, 170), true);
  flight.autopilot.Send(control::PositionSetpoint{{0, 0, -10}, Radians(-170)});
  flight.Run(10, [&] { EXPECT_GT(std::abs(Degrees(flight.Angles().yaw)), 165); });
  EXPECT_NEAR(Degrees(flight.Angles().yaw), -170, 1);
}

TEST(EmulatedAutopilot, HoldsItsPlaceInWind) {
  Conditions c;
  c.wind.mean_m_s = 6, c.wind.from_deg = 300;
  Flight flight(At(10, 45), true, c);
  flight.Run(15);
  flight.Run(5, [&] { EXPECT_LT((flight.X_NB().p - Vector3d(0, 0, -10)).norm(), 0.1); });
  EXPECT_GT(flight.TiltDeg(), 1);  // it leans against it
}

TEST(EmulatedAutopilot, KeepsItsLimits) {
  const auto most = [](const control::Setpoint& setpoint, double duration_s, auto value) {
    Flight flight(At(60, 40), true);
    flight.Run(1);
    double max_value = 0;
    flight.Keep(setpoint, duration_s, [&] { max_value = std::max(max_value, double(value(flight))); });
    return max_value;
  };
  const auto level_speed = [](const Flight& f) { return f.v_N().head<2>().norm(); };
  const auto expect_near_limit = [](double value, double limit, double overshoot) {
    EXPECT_LT(value, (1 + overshoot) * limit);
    EXPECT_GT(value, 0.95 * limit);  // it is the limit that acts, nothing slower
  };
  expect_near_limit(most(control::VelocitySetpoint{{8, -6, 0}, 0}, 8, level_speed), 3, 0.15);
  expect_near_limit(most(control::PositionSetpoint{{30, 40, -60}, 0}, 8, level_speed), 3, 0.15);
  expect_near_limit(
      most(control::VelocitySetpoint{{0, 0, -9}, 0}, 4, [](const Flight& f) { return -f.v_N().z(); }), 2,
      0.15);
  expect_near_limit(
      most(control::VelocitySetpoint{{0, 0, 9}, 0}, 4, [](const Flight& f) { return f.v_N().z(); }), 2, 0.15);
  // 4.6 % is the overshoot of a step at that damping
  expect_near_limit(most(control::AttitudeSetpoint{1.2, 0, 0, HoverThrust()}, 1.5,
                         [](const Flight& f) { return f.TiltDeg(); }),
                    45, 0.06);
  expect_near_limit(most(control::AttitudeSetpoint{0, -1.2, 0, HoverThrust()}, 1.5,
                         [](const Flight& f) { return f.TiltDeg(); }),
                    45, 0.06);
  expect_near_limit(
      most(control::VelocitySetpoint{{0, 0, 0}, 6}, 4, [](const Flight& f) { return Degrees(f.w_B().z()); }),
      90, 0.06);
}

TEST(EmulatedAutopilot, ASetpointThatIsNotKeptUpGoesStaleAndThePlaceIsHeld) {
  for (const control::Setpoint& setpoint :
       {control::Setpoint(control::VelocitySetpoint{{1.5, -1, 0}, 0.3}),
        control::Setpoint(control::AttitudeSetpoint{0.1, 0, 0, HoverThrust()})}) {
    Flight flight(At(30, 70), true);
    flight.Keep(setpoint, 2);  // last sent 0.05 s before the end
    flight.Run(0.43);
    EXPECT_NE(flight.mode(), control::FlightMode::kHold);
    flight.Run(0.04);
    EXPECT_EQ(flight.mode(), control::FlightMode::kHold);
    const Vector3d place = flight.X_NB().p;
    const double yaw = flight.Angles().yaw;
    flight.Run(12);
    EXPECT_EQ(flight.mode(), control::FlightMode::kHold);
    EXPECT_LT((flight.X_NB().p - place).norm(), 0.1);
    EXPECT_NEAR(flight.Angles().yaw, yaw, 0.05);
    EXPECT_LT(flight.v_N().norm(), 0.05);
    flight.Keep(control::VelocitySetpoint{}, 0.1);
    EXPECT_EQ(flight.mode(), control::FlightMode::kVelocity);
  }
}

TEST(EmulatedAutopilot, TakesOffOnAPositionAboveItAndOnlyThen) {
  Flight flight(At(kStandingHeight_m, 25), false);
  flight.Run(1);
  EXPECT_TRUE(flight.autopilot.State().landed);
  const control::Setpoint no_take_off[] = {
      control::VelocitySetpoint{{0, 0, -1}, 0}, control::AttitudeSetpoint{0, 0, 0, 0.8},
      control::PositionSetpoint{{0, 0, 0}, 0}, control::PositionSetpoint{{0, 0, -kStandingHeight_m - 0.2}, 0},
      control::PositionSetpoint{{3, 0, 5}, 0}};
  for (const control::Setpoint& setpoint : no_take_off) {
    flight.Keep(setpoint, 0.5);
    EXPECT_EQ(flight.mode(), control::FlightMode::kStopped);
    EXPECT_TRUE(flight.autopilot.State().landed);
    EXPECT_EQ(flight.Throttle(), 0);
  }
  EXPECT_LT(std::abs(flight.Height() - kStandingHeight_m), 0.01);

  flight.autopilot.Send(control::PositionSetpoint{{0, 0, -2}, Radians(25)});
  EXPECT_EQ(flight.mode(), control::FlightMode::kTakeOff);
  EXPECT_FALSE(flight.autopilot.State().landed);
  flight.Run(0.2);
  EXPECT_EQ(flight.mode(), control::FlightMode::kTakeOff);
  flight.Run(10, [&] { EXPECT_LT(flight.X_NB().p.head<2>().norm(), 0.1); });
  EXPECT_EQ(flight.mode(), control::FlightMode::kPosition);
  EXPECT_NEAR(flight.Height(), 2, 0.05);
  EXPECT_NEAR(Degrees(flight.Angles().yaw), 25, 1);
}

TEST(EmulatedAutopilot, StopsItsMotorsSoonAfterTouchingDown) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Conditions c;
    c.seed = seed;
    if (seed > 2) c.sensors = {}, c.wind = GustyWind();
    Flight flight(At(1.2, 10), true, c);
    flight.Run(3);
    const control::VelocitySetpoint down{{0, 0, 0.2}, 0};
    double touched_s = -1, stopped_s = -1;
    flight.Keep(down, 20, [&] {
      if (touched_s < 0 && flight.Touching()) touched_s = flight.t_s;
      if (stopped_s < 0 && flight.autopilot.State().landed) stopped_s = flight.t_s;
      EXPECT_FALSE(flight.autopilot.State().landed && touched_s < 0) << "stopped in the air, seed " << seed;
    });
    ASSERT_GT(touched_s, 3) << seed;
    ASSERT_GT(stopped_s, touched_s) << seed;
    EXPECT_LT(stopped_s - touched_s, 3) << seed;
    EXPECT_EQ(flight.mode(), control::FlightMode::kStopped) << seed;
    EXPECT_LT(flight.Throttle(), 0.01) << seed;
    EXPECT_LT(flight.TiltDeg(), 3) << seed;
  }
}

TEST(EmulatedAutopilot, TheMotorsKeepRunningInTheAir) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Conditions c;
    c.seed = seed, c.sensors = {}, c.wind = GustyWind();
    Flight flight(At(8, 10), true, c);
    double lowest = 8, weakest = 10;
    const auto watch = [&] {
      lowest = std::min(lowest, flight.Height());
      if (flight.t_s > 1) weakest = std::min(weakest, flight.Throttle());
      ASSERT_FALSE(flight.autopilot.State().landed) << "seed " << seed << ", " << flight.t_s << " s";
    };
    flight.Run(1);
    flight.Keep(control::VelocitySetpoint{{0.3, -0.2, 0}, 0}, 8, watch);  // level
    // the beginning of a descent, over and over, slow ones too
    for (int i = 0; i < 5; ++i) {
      flight.Keep(control::VelocitySetpoint{{0, 0, 0.13}, 0}, 1.2, watch);
      flight.Keep(control::VelocitySetpoint{{0, 0, 0.2}, 0}, 1.2, watch);
      flight.Keep(control::VelocitySetpoint{{0, 0, -0.3}, 0}, 1.2, watch);
    }
    flight.Keep(control::VelocitySetpoint{{0, 0, 0.2}, 0}, 8, watch);
    EXPECT_GT(lowest, 2) << seed;
    EXPECT_GT(weakest, 0.6) << seed;
  }
}

TEST(EmulatedAutopilot, TheMotorsKeepRunningWhereItBrakesAboveADeck) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Conditions c;
    c.seed = seed, c.sensors = {}, c.wind = GustyWind();
    c.autopilot.touch_down_lag_m_s = 0.5;
    c.autopilot.speed_limit_m_s = 14, c.autopilot.acceleration_limit_m_s2 = 4;
    c.autopilot.tilt_limit_deg = 35;
    Flight flight(At(30), true, c);
    const auto watch = [&] {
      ASSERT_FALSE(flight.autopilot.State().landed) << "seed " << seed << ", " << flight.t_s << " s";
    };
    for (int i = 0; i < 3; ++i) {
      flight.Keep(control::VelocitySetpoint{{13, 0, -0.2}, 0}, 5, watch);
      flight.Keep(control::VelocitySetpoint{{9, 3, 0.2}, 0}, 0.7, watch);
      flight.Keep(control::VelocitySetpoint{{5, -3, 1.6}, 0}, 1.5, watch);
    }
    EXPECT_GT(flight.Height(), 15) << seed;
  }
}

TEST(EmulatedAutopilot, TakesOffAgainAfterALanding) {
  Flight flight(At(0.6), true);
  flight.Keep(control::VelocitySetpoint{{0, 0, 0.25}, 0}, 6);
  ASSERT_TRUE(flight.autopilot.State().landed);
  flight.Keep(control::VelocitySetpoint{{0, 0, 0.25}, 0}, 1);
  EXPECT_TRUE(flight.autopilot.State().landed);
  flight.autopilot.Send(control::PositionSetpoint{flight.X_NB().p - Vector3d(0, 0, 1.5), 0});
  flight.Run(8);
  EXPECT_NEAR(flight.Height(), 1.5 + kStandingHeight_m, 0.1);
}

TEST(EmulatedAutopilot, SaysWhenItIsSaturated) {
  Flight flight(At(60), true);
  flight.Run(2, [&] { EXPECT_FALSE(flight.autopilot.State().saturated); });
  flight.Keep(control::AttitudeSetpoint{0, 0, 0, 1}, 0.5);
  EXPECT_TRUE(flight.autopilot.State().saturated);  // the motors
  flight.Keep(control::AttitudeSetpoint{0, 0, 0, HoverThrust()}, 0.5);
  EXPECT_FALSE(flight.autopilot.State().saturated);
  flight.Keep(control::AttitudeSetpoint{1, 0, 0, HoverThrust()}, 0.5);
  EXPECT_TRUE(flight.autopilot.State().saturated);  // the tilt, asked for
  flight.Keep(control::AttitudeSetpoint{0, 0, 0, HoverThrust()}, 0.5);
  EXPECT_FALSE(flight.autopilot.State().saturated);

  Conditions c;
  c.autopilot.tilt_limit_deg = 5;
  Flight leaning(At(60), true, c);
  leaning.Keep(control::VelocitySetpoint{{3, 0, 0}, 0}, 0.8);
  EXPECT_TRUE(leaning.autopilot.State().saturated);  // the tilt, needed for the acceleration
  leaning.Keep(control::AttitudeSetpoint{0, 0, 0, HoverThrust()}, 0.5);
  EXPECT_FALSE(leaning.autopilot.State().saturated);
}

TEST(EmulatedAutopilot, ItsClockRunsFromWhereItIsSet) {
  Flight flight(At(10), true);
  flight.autopilot.SetClock(-2);
  flight.Run(0.5);
  EXPECT_NEAR(flight.autopilot.State().t_s, -1.5, 1e-9);
}

Conditions WithFault(const std::string& type, double from_s, double until_s) {
  Conditions c;
  c.sensors = {};
  c.wind = GustyWind();
  c.sensors.attitude_faults = {{type, from_s, until_s, {3, -2, 2}}};
  return c;
}

// How far a flight with a fault from 5 s on parts from the same one without, when it is sent the true
// attitude at 20 Hz, or when it is not.
struct Apart {
  double tilt_deg = 0, yaw_deg = 0, height_m = 0;
};
Apart PartedBy(const std::string& type, double length_s, bool aided) {
  Conditions sound = WithFault(type, 5, 60);
  sound.sensors.attitude_faults.clear();
  Flight flight(At(60, 40), true, WithFault(type, 5, 60)), same(At(60, 40), true, sound);
  flight.Run(5), same.Run(5);
  Apart apart;
  int steps = 0;
  flight.Run(length_s, [&] {
    if (aided && steps++ % 25 == 0) flight.autopilot.Aid({flight.X_NB().R, 0.01});
    EXPECT_EQ(flight.autopilot.State().aided, aided);
    same.Run(kDt);
    const Vector3d down = flight.X_NB().R.conjugate() * Vector3d::UnitZ();
    const Vector3d same_down = same.X_NB().R.conjugate() * Vector3d::UnitZ();
    apart.tilt_deg = std::max(apart.tilt_deg, Degrees(std::acos(std::min(1.0, down.dot(same_down)))));
    apart.yaw_deg =
        std::max(apart.yaw_deg, Degrees(std::abs(WrapAngle(YawOf(flight.X_NB().R) - YawOf(same.X_NB().R)))));
    apart.height_m = std::max(apart.height_m, std::abs(flight.Height() - same.Height()));
  });
  return apart;
}

TEST(EmulatedAutopilot, RatesAreFollowedAndNoLevelIsSought) {
  for (int axis = 0; axis < 3; ++axis) {
    Flight flight(At(60), true);
    flight.Run(1);
    control::RateSetpoint setpoint{Vector3d::Zero(), HoverThrust()};
    setpoint.w_B[axis] = 0.5;
    flight.Keep(setpoint, 0.3);
    EXPECT_EQ(flight.mode(), control::FlightMode::kRates);
    EXPECT_NEAR(flight.w_B()[axis], 0.5, 0.03) << axis;
    const double angle = LogRotation(flight.X_NB().R)[axis];
    flight.Keep(control::RateSetpoint{Vector3d::Zero(), HoverThrust()}, 0.5);
    EXPECT_NEAR(flight.w_B()[axis], 0, 0.03) << axis;
    EXPECT_GT(LogRotation(flight.X_NB().R)[axis], angle) << axis;
  }
}

TEST(EmulatedAutopilot, RatesMustBeKeptUpElseItHoldsItsPlaceFromWhereItIs) {
  Flight flight(At(60), true);
  flight.Keep(control::RateSetpoint{{0.3, 0, 0}, HoverThrust()}, 0.5);
  EXPECT_GT(flight.TiltDeg(), 6);
  flight.Run(AutopilotParameters{}.command_timeout_s + 0.02);
  EXPECT_EQ(flight.mode(), control::FlightMode::kHold);
  const Vector3d there = flight.X_NB().p;
  flight.Run(8);
  EXPECT_LT(flight.TiltDeg(), 2);
  EXPECT_LT((flight.X_NB().p - there).norm(), 2.5);
  EXPECT_LT(flight.v_N().norm(), 0.2);
}

TEST(EmulatedAutopilot, AFailingAttitudeTakesTheAircraftWithIt) {
  for (const char* type : {"drift", "freeze", "silent"}) {
    EXPECT_GT(PartedBy(type, 12, false).tilt_deg, 15) << type;
  }
}

TEST(EmulatedAutopilot, AnAttitudeFromOutsideTakesThePlaceOfAFailingOne) {
  for (const char* type : {"drift", "freeze", "silent"}) {
    const Apart apart = PartedBy(type, 30, true);
    EXPECT_LT(apart.tilt_deg, 4) << type;
    EXPECT_LT(apart.yaw_deg, 4) << type;
    EXPECT_LT(apart.height_m, 0.5) << type;
  }
}

TEST(EmulatedAutopilot, AnAttitudeFromOutsideGoesStale) {
  Flight flight(At(60), true);
  const Eigen::Quaterniond other(RotationFromTaitBryan({0, 0.02, 0}));
  flight.autopilot.Aid({other, 0.01});
  EXPECT_EQ(flight.autopilot.State().R_NB.coeffs(), other.coeffs());
  flight.Run(AutopilotParameters{}.command_timeout_s - 0.01);
  EXPECT_TRUE(flight.autopilot.State().aided);
  flight.Run(0.02);
  EXPECT_FALSE(flight.autopilot.State().aided);
  EXPECT_LT(flight.autopilot.State().R_NB.angularDistance(flight.X_NB().R), 1e-3);
}

TEST(EmulatedAutopilot, ItsOwnAttitudeIsSilentOrFrozenWhileItFailsAndLevelledAnewAfterwards) {
  for (const char* type : {"drift", "freeze", "silent"}) {
    Flight flight(At(60), true, WithFault(type, 1, 6));
    const auto own = [&] { return flight.autopilot.State().R_NB_inertial; };
    flight.Run(1.01);
    const auto first = own();
    int steps = 0;
    flight.Run(4.9, [&] {
      if (steps++ % 25 == 0) flight.autopilot.Aid({flight.X_NB().R, 0.01});
      EXPECT_EQ(own().has_value(), type != std::string("silent"));
      if (type == std::string("freeze")) {
        EXPECT_EQ(own()->coeffs(), first->coeffs());
      }
    });
    if (type == std::string("drift")) {
      EXPECT_GT(Degrees(own()->angularDistance(flight.X_NB().R)), 5);
    }
    flight.Run(0.2);
    ASSERT_TRUE(own()) << type;
    EXPECT_LT(Degrees(own()->angularDistance(flight.X_NB().R)), 6) << type;
    flight.Run(10);
    EXPECT_LT(Degrees(own()->angularDistance(flight.X_NB().R)), 3) << type;
  }
}

}  // namespace
}  // namespace kestrel::sim
