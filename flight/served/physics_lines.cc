// SPDX-License-Identifier: Apache-2.0
#include "flight/served/physics_lines.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <optional>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/user_file.h"
#include "sim/server/physics/ardupilot_physics.h"
#include "sim/server/physics/parameter_file.h"
#include "sim/server/physics/px4_physics.h"

namespace kestrel::flight {
namespace {

std::filesystem::path FolderOf(std::string vehicle) {
  Mistakes none;  // it was loaded
  const auto file = ModelFile(Model::kVehicle, vehicle, {}, Place{}, none);
  return std::filesystem::absolute(file.value_or(vehicle)).parent_path();
}

std::string HostIn(const std::string& where) {
  const std::size_t from = where.find("://") + 3;
  std::string host = where.substr(from, where.rfind(':') - from);
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  return host;
}

int PortIn(const std::string& where) {
  int port = 0;
  const std::size_t from = where.rfind(':') + 1;
  std::from_chars(where.data() + from, where.data() + where.size(), port);
  return port;
}

// Of ArduPilot's own defaults and ours, the later file has the last word.
std::string ArduPilotCommand(const std::string& where, const std::optional<std::string>& parameters) {
  std::string command = fmt::format("build/sitl/bin/arducopter --model JSON:{}", HostIn(where));
  if (const int port = PortIn(where); port != sim::ArduPilotPhysicsParameters{}.port)
    command += fmt::format(" --sim-port-out {}", port);
  command += " --defaults Tools/autotest/default_params/copter.parm";
  if (parameters) command += ',' + *parameters;
  return command;
}

// It connects to the port of its instance.
std::optional<int> Px4InstanceAt(const std::string& where) {
  constexpr int kInstances = 10;
  const int instance = PortIn(where) - sim::Px4PhysicsParameters{}.port;
  if (instance < 0 || instance >= kInstances) return std::nullopt;
  return instance;
}

// Its start script takes parameters from the environment.
std::string Px4Command(const std::string& where, int instance, const std::optional<std::string>& parameters) {
  std::string command = "env PX4_SIM_MODEL=none_iris";
  if (const std::string host = HostIn(where); host != "127.0.0.1")
    command += fmt::format(" PX4_SIM_HOST_ADDR={}", host);
  if (parameters)
    command += fmt::format(" $(awk '/^[0-9]/ {{print \"PX4_PARAM_\" $3 \"=\" $4}}' {})", *parameters);
  command += " build/px4_sitl_default/bin/px4";
  if (instance > 0) command += fmt::format(" -i {}", instance);
  return command;
}

}  // namespace

std::string PhysicsLines(const std::string& kind, const std::string& where, const std::string& vehicle,
                         const std::string& fly) {
  const std::filesystem::path folder = FolderOf(vehicle);
  std::optional<std::string> parameters = (folder / sim::ParameterFileName(kind, vehicle)).string();
  std::string lines;
  if (!IsFile(*parameters)) {
    parameters.reset();
    lines += fmt::format(
        "  its parameters are not there; first:  kestrel vehicle parameters {} --autopilot {} --out {}\n",
        vehicle, kind, folder.string());
  }
  std::string autopilot = "tcp://127.0.0.1:5760";
  if (kind == "px4") {
    const std::optional<int> instance = Px4InstanceAt(where);
    if (!instance)
      return lines + "  PX4 connects to the ports 4560 to 4569, each instance to one: not to this one\n";
    lines += fmt::format("  to fly it:  in PX4's folder  {}\n", Px4Command(where, *instance, parameters));
    autopilot = fmt::format("udpin://127.0.0.1:{}", 14540 + *instance);
  } else {
    lines += fmt::format("  to fly it:  in ArduPilot's folder  {}\n", ArduPilotCommand(where, parameters));
  }
  if (fly.empty()) return lines;
  return lines +
         fmt::format(
             "        then  {} --autopilot mavlink:{} --take-control --arm\n"
             "              (it stands on the ground; a flight that does not take off by itself, such as "
             "landing, comes after one that does)\n",
             fly, autopilot);
}

}  // namespace kestrel::flight
