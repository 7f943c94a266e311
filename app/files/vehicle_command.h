// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "sim/vehicle_draft.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel vehicle new`: a vehicle file from what is known of an aircraft before it is measured.
// `kestrel vehicle parameters`: what a real autopilot has to be told of a vehicle to fly it.
struct VehicleArguments {
  sim::VehicleDraft draft;
  std::string vehicle, autopilot;   // of `parameters`: a name in models/vehicles or a file; ardupilot or px4
  std::filesystem::path out = ".";  // folder
  bool parameters = false;          // which of them
};

CLI::App* AddVehicleCommand(CLI::App& app, VehicleArguments& arguments);

// Writes NAME.yaml, or ardupilot.parm or px4.params. Throws InputError: it could not fly, or there is such a file
// already, or it cannot be written.
void VehicleCommand(const VehicleArguments& arguments);

}  // namespace kestrel::app
