// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/file/model_files.h"

namespace kestrel::campaign {

// The files that every flight by a scenario is read from anew: its own, that of the gains it names, and its
// models: vehicle, camera, world and pad.
class ScenarioFiles {
 public:
  // set: as for every flight; varying: keys that are others from flight to flight, of which all models are
  // meant that there are. Throws InputError: the scenario or its gains are not valid.
  ScenarioFiles(const std::string& scenario, const std::vector<std::string>& set,
                const std::vector<std::string>& varying);
  // The models, "NAME HASH" a line; of one in models/ the name there.
  std::string Models() const;
  // Throws std::runtime_error: one is not as it was then.
  void RequireUnchanged() const;

 private:
  void AddModel(Model model, const std::filesystem::path& file);
  void AddModels(const std::filesystem::path& file_or_folder);

  std::map<std::filesystem::path, std::string> text_of_;
  std::map<std::string, std::filesystem::path> models_;
};

}  // namespace kestrel::campaign
