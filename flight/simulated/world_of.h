// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/file/model_files.h"
#include "sim/landscape/landscape.h"
#include "sim/world/additions.h"

namespace kestrel::flight {

// A world as its file has it, before the scenario's own words.
struct LoadedWorld {
  std::filesystem::path file;  // the MJCF, or the file of the landscape
  std::optional<sim::LandscapeParameters> landscape;
  sim::WorldAdditions additions;
};

// name: of a world in models/worlds, or a file. None: there is no such; nobody says so yet.
std::optional<LoadedWorld> WorldOf(std::string name, const std::filesystem::path& beside, Mistakes& mistakes);

// The names of those worlds in models/worlds that are landscapes.
std::vector<std::string> LandscapeNames();

// Finds the files of meshes and photo beside a folder, and then from the working directory; their names become the
// whole paths. What is not there is a mistake.
void FindAdditions(std::vector<sim::MeshParameters>& meshes, std::optional<sim::GroundPhotoParameters>& photo,
                   const std::filesystem::path& beside, const Config& config, const Place& file,
                   Mistakes& mistakes);

}  // namespace kestrel::flight
