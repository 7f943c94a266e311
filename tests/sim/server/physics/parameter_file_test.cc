// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/parameter_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/server/physics/motor_layout.h"
#include "tests/sim/on_ground.h"
#include "tests/sim/parameters_read_back.h"

namespace kestrel::sim {
namespace {

// Of all the rotors for a signal of 0 to 1, as the simulator turns them.
double Thrust_n(const MultirotorParameters& aircraft, double signal, double curvature) {
  const MotorMapping mapping(Px4MotorOrder(aircraft), aircraft);
  MotorCommands commands;
  commands.fill(signal);
  const auto speeds = std::get<RotorSpeeds>(mapping.Speeds(commands, curvature));
  double thrust = 0;
  for (const double speed : speeds) thrust += aircraft.rotor.thrust_coefficient_n_s2 * speed * speed;
  return thrust;
}

// ArduPilot makes a signal of a throttle so: AP_Motors_Thrust_Linearization::thrust_to_actuator, without a battery.
double ArduPilotSignal(const std::map<std::string, double>& p, double throttle) {
  const double e = p.at("MOT_THST_EXPO");
  const double u = (e - 1 + std::sqrt((1 - e) * (1 - e) + 4 * e * throttle)) / (2 * e);
  return p.at("MOT_SPIN_MIN") + (p.at("MOT_SPIN_MAX") - p.at("MOT_SPIN_MIN")) * u;
}

TEST(ParameterFile, TheHoverThrottleCarriesTheWeight) {
  for (const std::string& layout : PublishedLayoutNames()) {
    MultirotorParameters aircraft = PelicanWith(layout);
    aircraft.mass_kg *= static_cast<double>(aircraft.rotors.size()) / 4;
    const double weight = aircraft.mass_kg * 9.80665;
    const auto ardupilot = ReadArduPilotParameters(ParameterText("ardupilot", "any", aircraft));
    EXPECT_NEAR(Thrust_n(aircraft, ArduPilotSignal(ardupilot, ardupilot.at("MOT_THST_HOVER")), 0.65), weight,
                0.002 * weight)
        << layout;
    const auto px4 = ReadPx4Parameters(ParameterText("px4", "any", aircraft));
    EXPECT_EQ(px4.at("THR_MDL_FAC"), 0);
    EXPECT_NEAR(Thrust_n(aircraft, px4.at("MPC_THR_HOVER"), 0), weight, 0.002 * weight) << layout;
  }
}

TEST(ParameterFile, AHoverThrottleBeyondTheParametersLimitsIsBroughtThereAndSaid) {
  MultirotorParameters heavy;
  heavy.mass_kg = 2.6;  // of 2.86 that its rotors can lift
  const std::string text = ParameterText("ardupilot", "heavy", heavy);
  EXPECT_EQ(ReadArduPilotParameters(text).at("MOT_THST_HOVER"), 0.6875);
  EXPECT_NE(text.find("beyond 0.125 to 0.6875"), std::string::npos);
  EXPECT_EQ(ReadPx4Parameters(ParameterText("px4", "heavy", heavy)).at("MPC_THR_HOVER"), 0.8);
}

// The torques that PX4's control allocation takes the motors to have are those of the simulator's rotors.
TEST(ParameterFile, Px4IsToldOfEachMotorWhatItsOutputTurns) {
  MultirotorParameters odd = PelicanWith("hexa-x");  // in no layout that is known
  odd.rotors[1].x_m += 0.09, odd.rotors[4].y_m -= 0.07;
  int checked = 0;
  for (const MultirotorParameters& aircraft :
       {MultirotorParameters{}, PelicanWith("quad-x"), PelicanWith("octo-h"), odd}) {
    const auto p = ReadPx4Parameters(ParameterText("px4", "any", aircraft));
    const MotorMapping mapping(Px4MotorOrder(aircraft), aircraft);
    const auto count = static_cast<std::size_t>(p.at("CA_ROTOR_COUNT"));
    ASSERT_EQ(count, LayoutOf(aircraft).count);
    EXPECT_EQ(p.at("CA_AIRFRAME"), 0);
    EXPECT_EQ(p.at("MAV_TYPE"), count == 4 ? 2 : count == 6 ? 13 : 14);
    for (std::size_t i = 0; i < count; ++i, ++checked) {
      EXPECT_EQ(p.at("PWM_MAIN_FUNC" + std::to_string(i + 1)), 101 + static_cast<int>(i));
      MotorCommands commands{};
      commands[i] = 0.4;
      const auto speeds = std::get<RotorSpeeds>(mapping.Speeds(commands, 0));
      std::array<double, kMaxRotors> high;
      high.fill(1e6);
      const Wrench w =
          AerodynamicWrench(aircraft, speeds, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), high);
      const std::string rotor = "CA_ROTOR" + std::to_string(i) + "_";
      const double thrust = -w.force.z();
      EXPECT_GT(thrust, 1);
      // ActuatorEffectivenessRotors: position x axis, less the moment along the axis, -z.
      EXPECT_NEAR(w.torque.x() / thrust, -p.at(rotor + "PY"), 2e-4);
      EXPECT_NEAR(w.torque.y() / thrust, p.at(rotor + "PX"), 2e-4);
      // 0, as PX4 comes, would give way to its airframe's own.
      EXPECT_NE(p.at(rotor + "PX"), 0);
      EXPECT_NE(p.at(rotor + "PY"), 0);
      EXPECT_NEAR(w.torque.z() / thrust, p.at(rotor + "KM"), 1e-6);
    }
  }
  EXPECT_EQ(checked, 4 + 4 + 8 + 6);
}

TEST(ParameterFile, ArduPilotHasItsLayoutAndFastGyroscopes) {
  const auto p = ReadArduPilotParameters(ParameterText("ardupilot", "any", PelicanWith("octo-x")));
  EXPECT_EQ(p.at("FRAME_CLASS"), 3);
  EXPECT_EQ(p.at("FRAME_TYPE"), 1);
  EXPECT_GT(p.at("SIM_RATE_HZ"), 1.8 * 400);  // of SCHED_LOOP_RATE as it comes
  EXPECT_FALSE(p.contains("SCHED_LOOP_RATE"));
  EXPECT_FALSE(p.contains("GUID_TIMEOUT"));
  EXPECT_FALSE(p.contains("ARMING_CHECK"));
  for (const char* name :
       {"INS_ACCOFFS_X", "INS_ACCOFFS_Y", "INS_ACCOFFS_Z", "INS_ACC2OFFS_Z", "COMPASS_OFS_X"})
    EXPECT_NE(p.at(name), 0) << name;
  MultirotorParameters reversed = PelicanWith("octo-x");
  for (RotorPlace& r : reversed.rotors) r.spin = r.spin == "clockwise" ? "counterclockwise" : "clockwise";
  EXPECT_THROW(ParameterText("ardupilot", "any", reversed), std::runtime_error);
}

}  // namespace
}  // namespace kestrel::sim
