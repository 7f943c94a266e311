// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <stdexcept>

#include "base/file/files.h"
#include "base/user_file.h"
#include "flight/gains_file.h"
#include "flight/load_plugins.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {

namespace fs = std::filesystem;

ScenarioFiles::ScenarioFiles(const std::string& scenario, const std::vector<std::string>& set,
                             const std::vector<std::string>& varying) {
  const fs::path file = ScenarioFile(scenario);
  text_of_[file] = ReadFile(file);
  if (const auto gains = flight::NamedGains(file, set).file()) text_of_[*gains] = ReadFile(*gains);
  const auto varies = [&](const std::string& key) {
    return std::any_of(varying.begin(), varying.end(),
                       [&](const std::string& each) { return each == key || key.starts_with(each + '.'); });
  };
  const flight::Scenario s = flight::LoadScenario(scenario, set, false).scenario;
  const auto add = [&](Model model, std::string name, const fs::path& all, bool vary) {
    if (vary)
      for (const fs::path& data : DataFolders()) AddModels(data / all);
    Mistakes none;
    if (const auto found = ModelFile(model, name, file.parent_path(), "", none)) AddModel(model, *found);
  };
  for (const std::string& plugin : flight::LoadedPlugins()) AddModels(plugin);
  add(Model::kVehicle, s.vehicle, "models/vehicles", varies("vehicle"));
  add(Model::kWorld, s.world, "models/worlds", varies("world"));
  for (const sim::MeshParameters& mesh : s.meshes) AddModels(mesh.file);
  if (s.ground_photo) AddModels(s.ground_photo->file);
  if (varies("pad.name") || s.pad.name != "none")
    add(Model::kPad, s.pad.name, "models/pads", varies("pad.name"));
  add(Model::kCamera, s.camera, "models/cameras", varies("camera"));
}

void ScenarioFiles::AddModel(Model model, const fs::path& file) {
  if (model == Model::kCamera) return AddModels(file);
  const fs::path folder = file.parent_path();
  if (folder.filename() == file.stem()) return AddModels(folder);
  // One of the user's own, whose folder may hold anything else.
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().stem() == file.stem()) AddModels(entry.path());
}

void ScenarioFiles::AddModels(const fs::path& file_or_folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(file_or_folder)) {
    for (const auto& entry : fs::recursive_directory_iterator(file_or_folder))
      if (entry.is_regular_file()) files.push_back(entry.path());
  } else if (IsFile(file_or_folder)) {
    files.push_back(file_or_folder);
  }
  for (const fs::path& file : files) {
    std::string name = file.string();
    for (const fs::path& data : DataFolders()) {
      const std::string below = file.lexically_relative(data / "models").generic_string();
      if (!below.empty() && !below.starts_with("..")) {
        name = below;
        break;
      }
    }
    if (models_.try_emplace(name, file).second) text_of_[file] = ReadFile(file);
  }
}

std::string ScenarioFiles::Models() const {
  std::string lines;
  for (const auto& [name, file] : models_) {
    const std::string& text = text_of_.at(file);
    lines += fmt::format("{} {:016x}\n", name, XXH3_64bits(text.data(), text.size()));
  }
  return lines;
}

void ScenarioFiles::RequireUnchanged() const {
  for (const auto& [file, text] : text_of_)
    if (ReadFile(file) != text)
      throw std::runtime_error(
          fmt::format("{} was changed while it was flown by; what was flown before is kept", file.string()));
}

}  // namespace kestrel::campaign
