// SPDX-License-Identifier: Apache-2.0
// Step responses of whole helicopters against what is published of them, or follows from their parameters.
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

constexpr double kGravity = 9.80665, kDt = 0.001, kHigh = 1e6;
constexpr double kWake =
    0.9;  // what the wake's losses leave of the momentum, sim/aircraft/rotor/pitched_rotor.h
const Vector3d kZero = Vector3d::Zero();

// A helicopter that hovers, and may move along and about some axes of B only: each step by itself.
struct Freed {
  Freed(const HelicopterParameters& parameters, const Vector3d& moves, const Vector3d& turns)
      : p(parameters), state(HoverState(parameters)), controls(HoverControls(state)), v(moves), w(turns) {
    at_rest = AerodynamicWrench(p, state, kZero, kZero, kHigh);
  }
  void Step() {
    const Wrench now = AerodynamicWrench(p, state, v_B, w_B, kHigh);
    state = StepHelicopter(p, state, controls, v_B, w_B, kHigh, kDt);
    v_B += kDt / p.mass_kg * v.cwiseProduct(now.force - at_rest.force);
    w_B += kDt * w.cwiseProduct((now.torque - at_rest.torque).cwiseQuotient(p.inertia_kg_m2));
  }
  HelicopterParameters p;
  HelicopterState state;
  HelicopterControls controls;
  Vector3d v, w;  // 1: free, 0: held
  Vector3d v_B = kZero, w_B = kZero;
  Wrench at_rest;
};

// When a response first reaches a share of its last value, s.
double Reaches(const std::vector<double>& response, double share) {
  for (std::size_t i = 0; i < response.size(); ++i)
    if (response[i] / response.back() >= share) return kDt * static_cast<double>(i + 1);
  return 1e9;
}

// Roll and pitch: rotor and bar are one lag t_e = 16 / (Lock number of the bar, 0.8, times the rotor's
// speed), and with the fuselage p'' + p' / t_e + w^2 p = w^2 A / t_e cyclic, w^2 = (K + T h) / I (V.
// Gavrilets, B. Mettler, E. Feron, 2001). Here the bar has its own state: the shapes agree to a quarter of
// the step's end.
TEST(HelicopterSteps, RollAndPitchOfTheXCellAreThoseOfThePublishedSecondOrderModel) {
  const HelicopterParameters x = XCell();
  for (const int axis : {0, 1}) {
    Freed freed(x, kZero, Vector3d::Unit(axis));
    freed.controls.cyclic[axis == 0 ? 1 : 0] = 0.02;
    const double t_e = 16 / (0.8 * 167), w2 = (54 + 8.2 * kGravity * 0.235) / x.inertia_kg_m2[axis];
    const double gain = 1 + x.flapping.bar_mixing * x.flapping.bar_gain, end = gain * 0.02 / t_e;
    double rate = 0, change = 0, worst = 0, greatest = 0, model_greatest = 0;
    for (double t = 0; t < 1; t += kDt) {
      freed.Step();
      change += kDt * (w2 * (end - rate) - change / t_e), rate += kDt * change;
      worst = std::max(worst, std::abs(freed.w_B[axis] - rate));
      greatest = std::max(greatest, freed.w_B[axis]), model_greatest = std::max(model_greatest, rate);
    }
    EXPECT_LT(worst, 0.25 * end) << axis;
    EXPECT_NEAR(greatest / model_greatest, 1, 0.15) << axis;
  }
}

// Heave: blade elements with the momentum of the wake give for a step of collective
//   T_c = rho a s A U^2 / 6 q, Z_w = -rho a s A U / 8 q / m, q = 16 k l / (16 k l + a s), l the inflow over U
// (G. D. Padfield, Helicopter Flight Dynamics, ch. 4, there with k = 1): a climb of T_c / -Z_w / m, reached
// with the time constant -1 / Z_w, after an inflow that comes within hundredths of a second.
TEST(HelicopterSteps, CollectiveAsksForAClimbWithTheTimeConstantOfHeaveDamping) {
  for (const HelicopterParameters& p : {HelicopterParameters{}, XCell()}) {
    HelicopterParameters bare = p;  // the fuselage in the wake is not part of the formula
    bare.drag_area_m2.setZero();
    bare.horizontal_fin.area_m2 = 0;
    Freed freed(bare, Vector3d::UnitZ(), kZero);
    constexpr double kStep = 0.005;
    freed.controls.collective += kStep;
    const double U = p.drive.speed_rad_s * p.rotor.radius_m,
                 as = p.rotor.lift_slope_per_rad * Solidity(p.rotor);
    const double wake = 16 * kWake * freed.state.induced_m_s / U, q = wake / (wake + as);
    const double slope = kAirDensity * as * DiscArea(p.rotor) * U * q;
    const double time = p.mass_kg / (slope / 8), climb = slope * U / 6 * kStep / (slope / 8);
    std::vector<double> climbs;
    while (kDt * static_cast<double>(climbs.size()) < 8 * time)
      freed.Step(), climbs.push_back(-freed.v_B.z());
    EXPECT_NEAR(climbs.back(), climb, 0.05 * climb);
    EXPECT_NEAR(Reaches(climbs, 1 - std::exp(-1)), time, 0.1 * time);
  }
}

// Yaw: the gyro's gain K on the tail rotor's thrust, dT/dpitch = rho a s A U^2 / 6 q, at the end of the boom,
// is a first-order lag I / (l K dT/dpitch), behind the servo's.
TEST(HelicopterSteps, PedalsAskForARateWithTheTimeConstantOfTheGyrosLoop) {
  for (const HelicopterParameters& whole : {HelicopterParameters{}, XCell()}) {
    HelicopterParameters p = whole;
    p.heading_gyro.integral = 0;
    p.vertical_fin.area_m2 = 0;
    Freed freed(p, kZero, Vector3d::UnitZ());
    freed.controls.yaw_rate = 0.1;
    const PitchedRotorParameters& r = p.tail_rotor;
    const double U = p.tail_gear * p.drive.speed_rad_s * r.radius_m, as = r.lift_slope_per_rad * Solidity(r);
    const double wake = 16 * kWake * freed.state.tail_induced_m_s / U, q = wake / (wake + as);
    const double slope = kAirDensity * as * DiscArea(r) * U * U / 6 * q;
    const double damping = slope * 3 / 4 / U * p.tail_arm_m;  // what the swinging tail meets, per pitch
    const double stiffness = p.tail_arm_m * (slope * p.heading_gyro.gain_s + damping);
    const double time = p.inertia_kg_m2.z() / stiffness,
                 end = 0.1 * slope * p.heading_gyro.gain_s * p.tail_arm_m / stiffness;
    std::vector<double> rates;
    while (rates.size() < 1500) freed.Step(), rates.push_back(freed.w_B.z());
    EXPECT_NEAR(rates.back(), end, 0.1 * end);
    EXPECT_NEAR(Reaches(rates, 1 - std::exp(-1)), time + p.servo_s, 0.25 * (time + p.servo_s));
  }
}

}  // namespace
}  // namespace kestrel::sim
