// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/motor_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/sim/drafted_aircraft.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/published_layouts.h"

namespace kestrel::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// More thrust of a motor turns the aircraft as the autopilot that numbers it so expects: away from it, and
// against its spin.
TEST(MotorLayout, EachMotorTurnsTheAircraftAsItsAutopilotExpects) {
  int checked = 0;
  for (const std::string& name : PublishedLayoutNames()) {
    const MultirotorParameters aircraft = PelicanWith(name);
    const MotorOrder order = KnownMotorOrder(aircraft);
    EXPECT_EQ(order.Name(), name);
    const MotorMapping mapping(order, aircraft);
    const std::vector<PublishedMotor> motors = PublishedLayout(name, aircraft.arm_m);
    ASSERT_EQ(order.rotor.size(), motors.size()) << name;
    for (std::size_t i = 0; i < motors.size(); ++i, ++checked) {
      MotorCommands commands{};
      commands[i] = 0.5;
      const auto speeds = std::get<RotorSpeeds>(mapping.Speeds(commands, 0));
      std::array<double, kMaxRotors> high;
      high.fill(1e6);
      const Wrench wrench =
          AerodynamicWrench(aircraft, speeds, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), high);
      const double thrust = -wrench.force.z();
      const double max_thrust =
          aircraft.rotor.thrust_coefficient_n_s2 * std::pow(aircraft.rotor.max_speed_rad_s, 2);
      EXPECT_NEAR(thrust, max_thrust / 2, 1e-9);
      EXPECT_NEAR(wrench.torque.x(), -thrust * motors[i].y, 1e-9) << name << i;
      EXPECT_NEAR(wrench.torque.y(), thrust * motors[i].x, 1e-9) << name << i;
      EXPECT_NEAR(wrench.torque.z(), motors[i].yaw * thrust * aircraft.rotor.moment_coefficient_m, 1e-9)
          << name << i;
    }
  }
  EXPECT_EQ(checked, 3 * (4 + 6 + 8));
}

TEST(MotorLayout, ThePelicansPlusIsFoundWithoutAList) {
  const MotorOrder order = KnownMotorOrder(MultirotorParameters());
  EXPECT_EQ(order.Name(), "quad-plus");
  EXPECT_EQ(order.rotor, (std::vector<std::size_t>{1, 3, 0, 2}));  // right, left, front, back
  EXPECT_EQ(order.layout->frame_class, 1);
  EXPECT_EQ(order.layout->frame_type, 0);
}

// Numbers of ArduPilot's documentation of FRAME_CLASS and FRAME_TYPE.
TEST(MotorLayout, EachHasArduPilotsNumbers) {
  for (const std::string& name : PublishedLayoutNames()) {
    const MotorLayout& layout = *KnownMotorOrder(PelicanWith(name)).layout;
    EXPECT_EQ(layout.frame_class, name.starts_with("quad") ? 1 : name.starts_with("hexa") ? 2 : 3) << name;
    EXPECT_EQ(layout.frame_type, name.ends_with("plus") ? 0 : name.ends_with("x") ? 1 : 3) << name;
  }
}

MultirotorParameters Turned(const std::string& layout, double by_deg) {
  MultirotorParameters p = PelicanWith(layout);
  for (RotorPlace& r : p.rotors) {
    const double x = r.x_m, y = r.y_m, c = std::cos(Radians(by_deg)), s = std::sin(Radians(by_deg));
    r.x_m = c * x - s * y, r.y_m = s * x + c * y;
  }
  return p;
}

TEST(MotorLayout, AFrameThatIsALittleOffIsFoundAndOneBetweenTwoIsNot) {
  int refused = 0;
  for (const std::string& name : PublishedLayoutNames()) {
    if (name.ends_with("h")) continue;
    const double between_deg = name.starts_with("quad") ? 90 : name.starts_with("hexa") ? 60 : 45;
    for (const double sign : {-1, 1}) {
      EXPECT_EQ(KnownMotorOrder(Turned(name, sign * between_deg * 0.16)).Name(), name);
      EXPECT_THROW(KnownMotorOrder(Turned(name, sign * between_deg * 0.2)), std::runtime_error) << name;
      EXPECT_EQ(Px4MotorOrder(Turned(name, sign * between_deg * 0.2)).layout, nullptr) << name;
      ++refused;
    }
  }
  EXPECT_EQ(refused, 12);
}

std::string Refusal(const MultirotorParameters& p) {
  try {
    return KnownMotorOrder(p).Name();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
}

TEST(MotorLayout, WhatFitsNoneIsRefusedRotorByRotor) {
  MultirotorParameters one = PelicanWith("hexa-x");
  const RotorPlace was = one.rotors[2];
  one.rotors[2].spin = was.spin == "clockwise" ? "counterclockwise" : "clockwise";
  EXPECT_THAT(Refusal(one),
              AllOf(HasSubstr("hexa-x"), HasSubstr("rotors.2 is at x_m"), Not(HasSubstr("rotors.1 "))));
  MultirotorParameters moved = PelicanWith("octo-plus");
  moved.rotors[5].x_m += 0.06;
  EXPECT_THAT(Refusal(moved), AllOf(HasSubstr("octo-plus"), HasSubstr("rotors.5 is at x_m")));
  // An X whose motors turn the other way round has no numbers in the X, but those of an H.
  MultirotorParameters reversed = PelicanWith("quad-x");
  for (RotorPlace& r : reversed.rotors) r.spin = r.spin == "clockwise" ? "counterclockwise" : "clockwise";
  EXPECT_EQ(Refusal(reversed), "quad-h");
  MultirotorParameters five = PelicanWith("hexa-x");
  five.rotors.pop_back();
  EXPECT_THAT(Refusal(five), AllOf(HasSubstr("5 rotors"), HasSubstr("4, 6 and 8")));
  EXPECT_EQ(Px4MotorOrder(five).Name(), "5 rotors as listed");
  EXPECT_EQ(Px4MotorOrder(five).rotor, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST(MotorLayout, EachVehicleThatIsBegunHasALayout) {
  int count = 0;
  for (const auto& [layout, known] : {std::pair{"plus", "-plus"}, {"x", "-x"}, {"h", "-h"}}) {
    for (const auto& [rotors, kind] : {std::pair{4, "quad"}, {6, "hexa"}, {8, "octo"}}) {
      VehicleDraft draft;
      draft.name = "begun", draft.layout = layout, draft.rotors = rotors;
      EXPECT_EQ(Refusal(DraftedAircraft(draft)), std::string(kind) + known);
      ++count;
    }
  }
  EXPECT_EQ(count, 9);
}

TEST(MotorLayout, TheThrustCurveIsTheInverseOfTheAutopilots) {
  for (const double curvature : {0.0, 0.3, 0.65, 1.0}) {
    for (const double wanted : {0.0, 0.1, 0.45, 0.9, 1.0}) {
      // ArduPilot's AP_Motors and PX4's FunctionMotors make a command of a thrust so.
      const double c = curvature;
      const double command =
          c == 0 ? wanted : (c - 1 + std::sqrt((1 - c) * (1 - c) + 4 * c * wanted)) / (2 * c);
      EXPECT_NEAR(ThrustShare(command, curvature), wanted, 1e-12);
      EXPECT_NEAR(CommandFor(wanted, curvature), command, 1e-12);
    }
  }
  EXPECT_EQ(ThrustShare(-1, 0), 0);
  EXPECT_EQ(ThrustShare(7, 0.65), 1);
  EXPECT_EQ(ThrustShare(std::numeric_limits<double>::quiet_NaN(), 0), 0);
  EXPECT_EQ(ThrustShare(std::numeric_limits<double>::infinity(), 1), 0);
}

}  // namespace
}  // namespace kestrel::sim
