// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <stdexcept>

#include "base/file/files.h"
#include "base/file/model_files.h"
#include "flight/gains_file.h"
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
  const fs::path models = Root() / "models";
  AddModels(models / "vehicles" / (varies("vehicle") ? "" : s.vehicle));
  AddModels(models / "worlds" / (varies("world") ? "" : s.world));
  if (varies("pad.name") || s.pad.name != "none")
    AddModels(models / "pads" / (varies("pad.name") ? "" : s.pad.name));
  if (varies("camera")) AddModels(models / "cameras");
  const fs::path camera = s.camera;
  AddModels(camera.is_absolute() ? camera : models / "cameras" / (s.camera + ".yaml"));
}

void ScenarioFiles::AddModels(const fs::path& file_or_folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(file_or_folder)) {
    for (const auto& entry : fs::recursive_directory_iterator(file_or_folder))
      if (entry.is_regular_file()) files.push_back(entry.path());
  } else {
    files.push_back(file_or_folder);
  }
  for (const fs::path& file : files) {
    const std::string name = file.lexically_relative(Root() / "models").generic_string();
    models_[name.empty() || name.starts_with("..") ? file.string() : name] = file;
    text_of_[file] = ReadFile(file);
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
