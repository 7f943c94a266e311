// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "sim/vehicle_draft.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel vehicle new`: a vehicle file from what is known of an aircraft before it is measured.
struct VehicleArguments {
  sim::VehicleDraft draft;
  std::filesystem::path out = ".";  // folder
};

CLI::App* AddVehicleCommand(CLI::App& app, VehicleArguments& arguments);

// Writes NAME.yaml. Throws InputError: it could not fly, or there is such a file already, or it cannot be written.
void VehicleCommand(const VehicleArguments& arguments);

}  // namespace kestrel::app
