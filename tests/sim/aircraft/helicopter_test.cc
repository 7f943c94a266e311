// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/helicopter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/tait_bryan.h"
#include "sim/aircraft/rotor/rotor.h"
#include "tests/sim/aircraft/helicopters.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.80665, kDt = 0.002, kHigh = 1e6;
const Vector3d kZero = Vector3d::Zero();

// Its rotation alone, about a place that stands in still air: what rotors and fuselage do to each other.
struct Turning {
  explicit Turning(const HelicopterParameters& parameters)
      : p(parameters), state(HoverState(parameters)), controls(HoverControls(state)) {}
  void Step(double dt) {
    state = StepHelicopter(p, state, controls, kZero, w_B, kHigh, dt);
    const Vector3d J = p.inertia_kg_m2, torque = AerodynamicWrench(p, state, kZero, w_B, kHigh).torque;
    w_B += dt * (torque - bias - w_B.cross(J.cwiseProduct(w_B))).cwiseQuotient(J);
  }
  HelicopterParameters p;
  HelicopterState state;
  HelicopterControls controls;
  Vector3d w_B = kZero, bias = kZero;  // bias: a torque that is held against the helicopter's own
};

TEST(Helicopter, HoversWhereItsForcesAndTorquesCancel) {
  for (const HelicopterParameters& p : {HelicopterParameters{}, XCell()}) {
    const HelicopterState hover = HoverState(p);
    const Wrench w = AerodynamicWrench(p, hover, kZero, kZero, kHigh);
    EXPECT_NEAR(w.force.z(), -p.mass_kg * kGravity, 1e-9 * p.mass_kg * kGravity);
    EXPECT_NEAR(w.torque.z(), 0, 1e-9);
    EXPECT_NEAR(w.torque.y(), 0, 1e-9);
    const HelicopterLoads loads = LoadsOf(p, hover, kZero, kZero, kHigh);
    EXPECT_NEAR(loads.tail.thrust_n * p.tail_arm_m, loads.rotor.torque_n_m, 1e-9);
    EXPECT_NEAR(w.force.y(), -loads.tail.thrust_n, 1e-9);  // a clockwise rotor: the tail pushes left
    const HelicopterState next = StepHelicopter(p, hover, HoverControls(hover), kZero, kZero, kHigh, kDt);
    EXPECT_NEAR(next.drive.speed_rad_s, p.drive.speed_rad_s, 1e-9);
    EXPECT_NEAR(next.induced_m_s, hover.induced_m_s, 1e-9);
    EXPECT_NEAR(next.tail_induced_m_s, hover.tail_induced_m_s, 1e-9);
  }
}

TEST(Helicopter, HoveringTakesThePowerThatItsThrustsAndDragsAreWorth) {
  const HelicopterParameters p;
  const HelicopterState hover = HoverState(p);
  const HelicopterLoads loads = LoadsOf(p, hover, kZero, kZero, kHigh);
  const auto profile = [](const PitchedRotorParameters& r, double speed) {
    return r.blades * r.chord_m * r.radius_m * kAirDensity / 8 * r.drag_coefficient *
           std::pow(speed * r.radius_m, 3);
  };
  const double main = loads.rotor.thrust_n * hover.induced_m_s + profile(p.rotor, p.drive.speed_rad_s);
  const double tail =
      loads.tail.thrust_n * hover.tail_induced_m_s + profile(p.tail_rotor, p.tail_gear * p.drive.speed_rad_s);
  EXPECT_NEAR(HoverPower_w(p), main + tail, 1e-6 * main);
  EXPECT_LT(tail, 0.25 * main);
  EXPECT_GT(HoverPower_w(p), 0.5 * p.drive.power_w);  // thesis table B.1: 1400 W, with which it also climbs
  EXPECT_LT(HoverPower_w(p), 0.8 * p.drive.power_w);
}

TEST(Helicopter, EachControlMovesItItsWay) {
  for (const bool clockwise : {true, false}) {
    HelicopterParameters p;
    p.clockwise = clockwise;
    const auto after = [&](auto change) {
      Turning t(p);
      t.bias = AerodynamicWrench(p, t.state, kZero, kZero, kHigh).torque;
      change(t.controls);
      for (int i = 0; i < 50; ++i) t.Step(kDt);
      return t;
    };
    EXPECT_GT(after([](HelicopterControls& c) { c.cyclic.x() = 0.02; }).w_B.y(), 0.05);
    EXPECT_LT(after([](HelicopterControls& c) { c.cyclic.x() = -0.02; }).w_B.y(), -0.05);
    EXPECT_GT(after([](HelicopterControls& c) { c.cyclic.y() = 0.02; }).w_B.x(), 0.05);
    EXPECT_GT(after([](HelicopterControls& c) { c.yaw_rate = 0.3; }).w_B.z(), 0.05);
    const Turning lifted = after([](HelicopterControls& c) { c.collective += 0.01; });
    EXPECT_LT(AerodynamicWrench(p, lifted.state, kZero, kZero, kHigh).force.z(),
              -1.03 * p.mass_kg * kGravity);
    // more torque of the main rotor turns the fuselage against it, until the gyro has it
    EXPECT_LT(lifted.w_B.z() * (clockwise ? 1 : -1), 0);
  }
}

// Frequency of the rates' oscillation about an axis after a kick of cyclic, rad/s, from the first minimum and
// the first maximum after it.
double CoupledFrequency(const HelicopterParameters& p, int axis) {
  Turning t(p);
  t.bias = AerodynamicWrench(p, t.state, kZero, kZero, kHigh).torque;
  t.controls.cyclic = axis == 0 ? Eigen::Vector2d(0, 0.02) : Eigen::Vector2d(0.02, 0);
  std::vector<double> rates;
  const double dt = 0.0005;
  for (int i = 0; i < 4000; ++i) t.Step(dt), rates.push_back(t.w_B[axis]);
  std::vector<std::size_t> turns;
  for (std::size_t i = 1; i + 1 < rates.size(); ++i)
    if ((rates[i] - rates[i - 1]) * (rates[i + 1] - rates[i]) < 0) turns.push_back(i);
  if (turns.size() < 2) return 0;
  return std::numbers::pi / (dt * static_cast<double>(turns[1] - turns[0]));
}

// Rotor and fuselage swing against each other at sqrt((K + T h) / I), with the damping 1 / (2 t_e w) of the
// bar and the rotor, t_e = 0.12 s: V. Gavrilets et al. for the X-Cell, 20.1 rad/s in roll and 14.6 rad/s in
// pitch.
TEST(Helicopter, RotorAndFuselageSwingAsThoseOfTheXCell) {
  const HelicopterParameters x = XCell();
  for (const int axis : {0, 1}) {
    const double w = std::sqrt((54 + 8.2 * kGravity * 0.235) / x.inertia_kg_m2[axis]);
    const double damped = w * std::sqrt(1 - std::pow(1 / (2 * 0.12 * w), 2));
    EXPECT_NEAR(CoupledFrequency(x, axis) / damped, 1, 0.12) << axis;
  }
}

// Between the X-Cell and the larger Yamaha R-50, of which B. Mettler, M. Tischler, T. Kanade
// (CMU-RI-TR-00-03, 2000) identified L_b = 166 and M_a = 82.6 1/s^2.
TEST(Helicopter, RotorAndFuselageOfTheSr20SwingBetweenSmallerAndLarger) {
  EXPECT_GT(CoupledFrequency({}, 0), std::sqrt(166.0));
  EXPECT_LT(CoupledFrequency({}, 0), 20.1);
  EXPECT_GT(CoupledFrequency({}, 1), std::sqrt(82.6));
  EXPECT_LT(CoupledFrequency({}, 1), 14.6);
}

// Cyclic in the end asks for a rate: where the disc lags by as much as it is tilted.
TEST(Helicopter, CyclicAsksForARate) {
  Turning t(HelicopterParameters{});
  t.bias = AerodynamicWrench(t.p, t.state, kZero, kZero, kHigh).torque;
  t.controls.cyclic = {0, 0.01};
  for (int i = 0; i < 400; ++i) t.Step(kDt);
  const double lag = FlapTime(t.p.rotor, t.p.flapping, 125) + 0.71 * BarTime(t.p.flapping, 125);
  EXPECT_NEAR(t.w_B.x(), (1 + 0.71 * 1.95) * 0.01 / lag, 0.1 * t.w_B.x());
}

TEST(Helicopter, PedalsAskForARateAndTheGyroHoldsTheHeading) {
  Turning t(HelicopterParameters{});
  t.controls.yaw_rate = 0.5;
  double risen_s = 0;
  for (int i = 0; i < 1000; ++i) {
    t.Step(kDt), t.w_B.x() = t.w_B.y() = 0;
    if (risen_s == 0 && t.w_B.z() > 0.5 * (1 - std::exp(-1))) risen_s = (i + 1) * kDt;
  }
  EXPECT_NEAR(t.w_B.z(), 0.5, 0.01);
  EXPECT_GT(risen_s, 0.05);
  EXPECT_LT(risen_s, 0.25);
  t.controls.yaw_rate = 0;
  double heading = 0;
  for (int i = 0; i < 2000; ++i) t.Step(kDt), t.w_B.x() = t.w_B.y() = 0;
  t.bias.z() = 1;  // a gust on the tail
  for (int i = 0; i < 2500; ++i) t.Step(kDt), t.w_B.x() = t.w_B.y() = 0, heading += kDt * t.w_B.z();
  EXPECT_NEAR(t.w_B.z(), 0, 1e-3);
  EXPECT_LT(std::abs(heading), Radians(6));
}

TEST(Helicopter, IsMirroredWithTheSenseOfItsRotor) {
  HelicopterParameters p, q;
  q.clockwise = false;
  HelicopterState a = HoverState(p), b = HoverState(q);
  HelicopterControls of_a = HoverControls(a), of_b = HoverControls(b);
  of_a.cyclic = {0.01, 0.02}, of_b.cyclic = {0.01, -0.02};
  of_a.yaw_rate = 0.3, of_b.yaw_rate = -0.3;
  Vector3d v(2, 1, -0.5), w(0.2, -0.1, 0.3);
  // a mirror across the plane of symmetry: velocities change their y, rates their x and z
  const auto mirrored_v = [](const Vector3d& x) { return Vector3d(x.x(), -x.y(), x.z()); };
  const auto mirrored_w = [](const Vector3d& x) { return Vector3d(-x.x(), x.y(), -x.z()); };
  for (int i = 0; i < 200; ++i) {
    a = StepHelicopter(p, a, of_a, v, w, 2, kDt);
    b = StepHelicopter(q, b, of_b, mirrored_v(v), mirrored_w(w), 2, kDt);
    const Wrench on_a = AerodynamicWrench(p, a, v, w, 2);
    const Wrench on_b = AerodynamicWrench(q, b, mirrored_v(v), mirrored_w(w), 2);
    ASSERT_LT((mirrored_v(on_a.force) - on_b.force).norm(), 1e-9) << i;
    ASSERT_LT((mirrored_w(on_a.torque) - on_b.torque).norm(), 1e-9) << i;
  }
  EXPECT_GT(a.flapping.disc.norm(), 1e-3);
}

TEST(Helicopter, NearTheGroundTheSamePitchLiftsMore) {
  const HelicopterParameters p;
  HelicopterState away = HoverState(p), near = away;
  for (int i = 0; i < 500; ++i) {
    away = StepHelicopter(p, away, HoverControls(away), kZero, kZero, kHigh, kDt);
    near = StepHelicopter(p, near, HoverControls(near), kZero, kZero, 0.5, kDt);
  }
  const double more = LoadsOf(p, near, kZero, kZero, 0.5).rotor.thrust_n /
                      LoadsOf(p, away, kZero, kZero, kHigh).rotor.thrust_n;
  EXPECT_GT(more, 1.05);
  EXPECT_LT(more, GroundEffect(p.rotor.radius_m, 0.5));  // which is for equal power
}

TEST(Helicopter, FuselageAndFinsDragAgainstTheMotion) {
  const HelicopterParameters p;
  HelicopterState still;  // nothing turns
  for (const Vector3d& v : {Vector3d(10, 0, 0), Vector3d(0, 10, 0), Vector3d(0, 0, 10), Vector3d(-7, 0, 0)}) {
    const Wrench w = AerodynamicWrench(p, still, v, kZero, kHigh);
    const double area = p.drag_area_m2.dot(v.cwiseAbs()) / v.norm();
    const double fin = (v.y() != 0 ? 0.012 : 0) + (v.z() != 0 ? 0.01 : 0);
    EXPECT_NEAR(-w.force.dot(v) / v.norm(), 0.5 * 1.225 * (area + fin) * v.squaredNorm(), 1e-9);
  }
  // slipping to the right at 10 m/s forward, the fin turns the nose into the flow
  EXPECT_GT(AerodynamicWrench(p, still, {10, 2, 0}, kZero, kHigh).torque.z(), 0.1);
  EXPECT_LT(AerodynamicWrench(p, still, {10, 0, 0}, {0, 0.5, 0}, kHigh).torque.y(), -0.01);  // pitch damping
}

TEST(RotorShake, TurnsOnceARevolutionAndOnceForEachBlade) {
  const RotorShake s;
  Vector3d mean = kZero;
  double turn = 0, pass = 0, nod = 0;
  constexpr int kSteps = 360;
  for (int i = 0; i < kSteps; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / kSteps;
    const ImuSample imu = ShakeAt(s, azimuth, 2, 1);
    mean += (imu.specific_force_B + imu.w_B) / kSteps;
    turn += 2.0 / kSteps * imu.specific_force_B.x() * std::cos(azimuth);
    pass += 2.0 / kSteps * imu.specific_force_B.z() * std::cos(2 * azimuth);
    nod += 2.0 / kSteps * imu.w_B.y() * std::sin(2 * azimuth);
  }
  EXPECT_LT(mean.norm(), 1e-12);
  EXPECT_NEAR(turn, s.turn_m_s2, 1e-12);
  EXPECT_NEAR(pass, s.blade_m_s2, 1e-12);
  EXPECT_NEAR(nod, s.blade_rad_s, 1e-12);
  EXPECT_NEAR(ShakeAt(s, 0, 2, 0.5).specific_force_B.z(), s.blade_m_s2 / 4, 1e-12);
  EXPECT_EQ(ShakeAt(s, 1, 2, 0).w_B, kZero);
}

}  // namespace
}  // namespace kestrel::sim
