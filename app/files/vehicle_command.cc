// SPDX-License-Identifier: Apache-2.0
#include "app/files/vehicle_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "app/option/one_of.h"
#include "app/option/within.h"
#include "base/diagnostics.h"
#include "base/process/shell_word.h"
#include "flight/simulated/scenario.h"
#include "sim/server/physics/motor_layout.h"
#include "sim/server/physics/parameter_file.h"

namespace kestrel::app {
namespace {

void AddParametersCommand(CLI::App& verb, VehicleArguments& a) {
  CLI::App* command = verb.add_subcommand(
      "parameters", "Write the parameters by which ArduPilot or PX4 flies a vehicle in the loop");
  command->add_option("vehicle", a.vehicle, "A name in models/vehicles, or a vehicle file")->required();
  command->add_option("--autopilot", a.autopilot, "Whose parameters")
      ->required()
      ->check(OneOf({"ardupilot", "px4"}));
  command
      ->add_option("--out", a.out,
                   "Folder that ardupilot.parm or px4.params is written to; of a vehicle file NAME.yaml "
                   "NAME.ardupilot.parm or NAME.px4.params")
      ->capture_default_str();
  command->callback([&a] { a.parameters = true; });
  command->footer(
      "Examples:\n"
      "  kestrel vehicle parameters mine.yaml --autopilot ardupilot\n"
      "  kestrel vehicle parameters pelican --autopilot px4 --out /tmp");
}

void WriteNew(const std::filesystem::path& file, const std::string& text, Mistakes& mistakes) {
  if (std::filesystem::exists(file))
    mistakes.Add(file.string(), "", "is there already", "give another name or folder, or remove it");
  mistakes.ThrowIfAny();
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw InputError(file.string(), "cannot be written");
}

void WriteParameters(const VehicleArguments& a) {
  Mistakes mistakes;
  std::string text;
  try {
    const flight::LoadedScenario loaded = flight::LoadScenario("hover", {"vehicle=" + a.vehicle}, false);
    text = sim::ParameterText(a.autopilot, a.vehicle, sim::MultirotorOf(loaded.simulator.vehicle));
  } catch (const InputError& e) {
    for (Diagnostic each : e.diagnostics) {
      if (each.file.starts_with("--set")) each.file = a.vehicle, each.key.clear();
      mistakes.Add(each);
    }
  } catch (const std::runtime_error& e) {
    mistakes.Add(a.vehicle, "", e.what());
  }
  const std::filesystem::path file = a.out / sim::ParameterFileName(a.autopilot, a.vehicle);
  WriteNew(file, text, mistakes);
  fmt::print("{}\nServe the aircraft by: kestrel serve hover --set vehicle={} --physics {}\n", file.string(),
             ShellWord(a.vehicle), a.autopilot);
}

}  // namespace

CLI::App* AddVehicleCommand(CLI::App& app, VehicleArguments& a) {
  CLI::App* verb =
      app.add_subcommand("vehicle", "Begin a vehicle of your own, or tell a real autopilot of one");
  verb->require_subcommand(1);
  CLI::App* command =
      verb->add_subcommand("new", "Write a vehicle file that flies, from mass, arms, rotors and battery");
  command->add_option("name", a.draft.name, "Name of the vehicle and its file")->required();
  command->add_option("--mass", a.draft.mass_kg, "Mass ready to fly, kg")
      ->required()
      ->check(Within(0.05, 50.0));
  command->add_option("--arm", a.draft.arm_m, "From the centre to each shaft, m")
      ->required()
      ->check(Within(0.05, 2.0));
  command->add_option("--layout", a.draft.layout, "Where the rotors are: plus, x, or h (two rails)")
      ->capture_default_str()
      ->check(OneOf({"plus", "x", "h"}));
  command->add_option("--rotors", a.draft.rotors, "How many: 4, 6 or 8")
      ->capture_default_str()
      ->check(CLI::IsMember({4, 6, 8}));
  command->add_option("--battery", a.draft.cells, "Lithium cells in series")
      ->capture_default_str()
      ->check(WholeNumber(1, 16));
  command
      ->add_option("--kv", a.draft.kv_rpm_v,
                   "Of the motors, rpm/V; without it --thrust-to-weight tells their speed")
      ->check(Within(20.0, 10000.0));
  command
      ->add_option("--propeller", a.draft.propeller_m,
                   "Diameter, m; without it the largest that leaves a gap of a tenth")
      ->check(Within(0.03, 3.0));
  command->add_option("--thrust-to-weight", a.draft.thrust_to_weight, "Of all rotors at full speed")
      ->capture_default_str()
      ->check(Within(0.1, 10.0));
  command->add_option("--out", a.out, "Folder that the file is written to")->capture_default_str();
  command->footer(
      "Examples:\n"
      "  kestrel vehicle new mine --mass 1.6 --arm 0.25 --rotors 6\n"
      "  kestrel vehicle new heavy --mass 6 --arm 0.5 --rotors 8 --battery 6 --kv 380 --propeller 0.35 --out "
      "vehicles\n"
      "  kestrel run hover --set vehicle=mine.yaml");
  AddParametersCommand(*verb, a);
  return verb;
}

void VehicleCommand(const VehicleArguments& a) {
  if (a.parameters) return WriteParameters(a);
  Mistakes mistakes;
  if (a.draft.name.empty() || a.draft.name.front() == '.' ||
      a.draft.name.find_first_of("/\"\\\n") != std::string::npos)
    mistakes.Add("kestrel vehicle new", "", fmt::format("'{}' cannot name a file", a.draft.name),
                 "valid: no slash, no quote, no leading dot");
  const std::string text = sim::VehicleText(a.draft, mistakes);
  const std::filesystem::path file = a.out / (a.draft.name + ".yaml");
  WriteNew(file, text, mistakes);
  fmt::print("{}\nFly it by: kestrel run hover --set vehicle={}\n", file.string(), ShellWord(file.string()));
}

}  // namespace kestrel::app
