// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "base/yaml/yaml_fields.h"
#include "sim/vehicle_draft.h"
#include "sim/vehicle_file.h"

namespace kestrel::sim {

// As `vehicle new` writes it and a flight reads it. Throws std::runtime_error: it could not fly.
inline MultirotorParameters DraftedAircraft(const VehicleDraft& draft) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("kestrel_drafted_" + std::to_string(::getpid()) + ".yaml");
  Mistakes mistakes;
  std::ofstream(file) << VehicleText(draft, mistakes);
  VehicleFile read;
  Read(LoadConfig(file, {}, mistakes), read, mistakes);
  std::filesystem::remove(file);
  mistakes.ThrowIfAny();
  return std::get<MultirotorParameters>(read.airframe);
}

}  // namespace kestrel::sim
