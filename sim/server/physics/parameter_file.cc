// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/parameter_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/gravity.h"
#include "sim/server/physics/ardupilot_physics.h"
#include "sim/server/physics/motor_layout.h"
#include "sim/server/physics/px4_physics.h"

namespace kestrel::sim {
namespace {

// What ArduPilot's motors are told for no thrust and for all of it, of the range of their signal: as it comes.
constexpr double kSpinMin = 0.15, kSpinMax = 0.95;

struct Parameter {
  std::string name, value;
  bool real = false;
};
struct Reason {
  std::string comment;
  std::vector<Parameter> parameters;
};

std::string Number(double value) { return fmt::format("{:.4g}", value); }

// Of the thrust that there is.
double HoverShare(const MultirotorParameters& aircraft) {
  return aircraft.mass_kg * kGravity_m_s2 /
         (static_cast<double>(LayoutOf(aircraft).count) * LimitsOf(aircraft.rotor).thrust_n);
}

// A thrust t leaves ArduPilot as spin_min + (spin_max - spin_min) u, with t = (1 - c) u + c u^2
// (AP_Motors_Thrust_Linearization.cpp).
double ArduPilotHover(const MultirotorParameters& aircraft, double curvature) {
  const double u = (CommandFor(HoverShare(aircraft), curvature) - kSpinMin) / (kSpinMax - kSpinMin);
  return ThrustShare(u, curvature);
}

// Within the limits of the parameter, which the autopilot's own learning goes on from.
Reason Hover(const char* name, double value, double least, double most) {
  const double within = std::clamp(value, least, most);
  std::string comment = "the throttle at which it hovers, from its weight and its rotors";
  if (within != value)
    comment = fmt::format("it hovers at a throttle of {}, beyond {:g} to {:g}, the parameter's limits",
                          Number(value), least, most);
  return {comment, {{name, Number(within), true}}};
}

std::vector<Reason> OfArduPilot(const MultirotorParameters& aircraft) {
  const MotorLayout& layout = *KnownMotorOrder(aircraft).layout;
  const double curvature = ArduPilotPhysicsParameters{}.thrust_curvature;
  std::vector<Reason> reasons = {
      {"the layout of its motors: " + layout.name,
       {{"FRAME_CLASS", std::to_string(layout.frame_class)},
        {"FRAME_TYPE", std::to_string(layout.frame_type)}}},
      {"the curve from signal to thrust, of which the simulator undoes the inverse",
       {{"MOT_THST_EXPO", Number(curvature)}}},
      {"the part of the signal that the hover throttle counts on: ArduPilot's own values",
       {{"MOT_SPIN_MIN", Number(kSpinMin)}, {"MOT_SPIN_MAX", Number(kSpinMax)}}},
      Hover("MOT_THST_HOVER", ArduPilotHover(aircraft, curvature), 0.125, 0.6875),
      {"the rotors do not slow down with a battery's voltage, so nothing is made up for it",
       {{"MOT_BAT_VOLT_MIN", "0"}, {"MOT_BAT_VOLT_MAX", "0"}}},
      {"the simulator's steps a second; gyroscopes below 1.8 times the loop's rate do not arm",
       {{"SIM_RATE_HZ", fmt::format("{:g}", 1 / kArduPilotFineStep_s)}}},
      {"accelerometers count as calibrated by these, of ArduPilot's own copter.parm for simulators", {}},
      {"the offsets of the compass that ArduPilot simulates (SIM_MAG1_OFS): it counts as calibrated",
       {{"COMPASS_OFS_X", "5"},
        {"COMPASS_OFS_Y", "13"},
        {"COMPASS_OFS_Z", "-18"},
        {"COMPASS_OFS2_X", "5"},
        {"COMPASS_OFS2_Y", "13"},
        {"COMPASS_OFS2_Z", "-18"},
        {"COMPASS_OFS3_X", "5"},
        {"COMPASS_OFS3_Y", "13"},
        {"COMPASS_OFS3_Z", "-18"}}}};
  Reason& accelerometers = reasons[6];
  for (const char* which : {"ACC", "ACC2"})
    for (const char* axis : {"X", "Y", "Z"}) {
      accelerometers.parameters.push_back({fmt::format("INS_{}OFFS_{}", which, axis), "0.001"});
      accelerometers.parameters.push_back({fmt::format("INS_{}SCAL_{}", which, axis), "1.001"});
    }
  return reasons;
}

// PX4 takes a value that is its own default for none, and then has that of its airframe.
double NotZero(double place_m) { return std::abs(place_m) < 1e-4 ? 1e-4 : place_m; }

std::vector<Reason> OfPx4(const MultirotorParameters& aircraft) {
  const MotorOrder order = Px4MotorOrder(aircraft);
  const RotorLayout rotors = LayoutOf(aircraft);
  const std::size_t count = order.rotor.size();
  Reason geometry{
      "where each motor is, m, and its torque over its thrust, m, positive for counterclockwise: " +
          order.Name() + "; 0.0001 is 0, which would give way to the airframe's own",
      {{"CA_AIRFRAME", "0"}, {"CA_ROTOR_COUNT", std::to_string(count)}}};
  Reason outputs{"the outputs of the simulator's message are these motors", {}};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t rotor = order.rotor[i];
    const std::string prefix = fmt::format("CA_ROTOR{}_", i);
    const double moment = aircraft.rotor.moment_coefficient_m;
    geometry.parameters.push_back({prefix + "PX", Number(NotZero(rotors.hubs_B[rotor].x())), true});
    geometry.parameters.push_back({prefix + "PY", Number(NotZero(rotors.hubs_B[rotor].y())), true});
    geometry.parameters.push_back(
        {prefix + "KM", Number(rotors.spins[rotor] == Spin::kCounterclockwise ? moment : -moment), true});
    outputs.parameters.push_back({fmt::format("PWM_MAIN_FUNC{}", i + 1), std::to_string(101 + i)});
  }
  const double curvature = Px4PhysicsParameters{}.thrust_curvature;
  return {{"what ground stations show it as: MAV_TYPE of MAVLink",
           {{"MAV_TYPE", count == 4   ? "2"
                         : count == 6 ? "13"
                         : count == 8 ? "14"
                                      : "35"}}},
          std::move(geometry),
          std::move(outputs),
          {"the curve from signal to thrust, of which the simulator undoes the inverse",
           {{"THR_MDL_FAC", Number(curvature), true}}},
          Hover("MPC_THR_HOVER", CommandFor(HoverShare(aircraft), curvature), 0.1, 0.8),
          {"there is no receiver: offboard goes on without manual control", {{"COM_RCL_EXCEPT", "4"}}}};
}

}  // namespace

std::string ParameterFileName(const std::string& autopilot, const std::string& vehicle) {
  const std::string name = autopilot == "px4" ? "px4.params" : "ardupilot.parm";
  const std::filesystem::path file = vehicle;
  const bool shares = file.has_extension() && file.parent_path().filename() != file.stem();
  return shares ? file.stem().string() + '.' + name : name;
}

std::string ParameterText(const std::string& autopilot, const std::string& vehicle,
                          const MultirotorParameters& aircraft) {
  const bool px4 = autopilot == "px4";
  std::string text = fmt::format(
      "# {} of the simulated aircraft, for: kestrel serve --physics {}\n"
      "# Written by: kestrel vehicle parameters {:.40} --autopilot {}\n"
      "# What is not here stays as {} comes.\n",
      px4 ? "PX4's parameters" : "ArduPilot's parameters", autopilot,
      std::filesystem::path(vehicle).filename().string(), autopilot, px4 ? "PX4" : "ArduPilot");
  if (px4) text += "# Vehicle-Id Component-Id Name Value Type\n";
  for (const Reason& reason : px4 ? OfPx4(aircraft) : OfArduPilot(aircraft)) {
    text += fmt::format("\n# {}\n", reason.comment);
    for (const Parameter& p : reason.parameters) {
      text += px4 ? fmt::format("1\t1\t{}\t{}\t{}\n", p.name, p.value, p.real ? 9 : 6)
                  : fmt::format("{} {}\n", p.name, p.value);
    }
  }
  if (!px4)
    text +=
        "\n# GUID_TIMEOUT stays at 3 s, for which it follows the last velocity, and WPNAV_ACCEL_Z at\n"
        "# 100 cm/s2, by which its velocity follows a vertical setpoint some 0.85 s late.\n";
  return text;
}

}  // namespace kestrel::sim
