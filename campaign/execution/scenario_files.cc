// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <stdexcept>

#include "scenarios/files.h"
#include "scenarios/gains_file.h"
#include "scenarios/model_files.h"
#include "scenarios/scenario.h"

namespace kestrel {

namespace fs = std::filesystem;

ScenarioFiles::ScenarioFiles(const std::string& scenario, const std::vector<std::string>& set) {
  const fs::path file = ScenarioFile(scenario);
  text_of_[file] = ReadFile(file);
  if (const auto gains = NamedGains(file, set).file()) text_of_[*gains] = ReadFile(*gains);
  const fs::path models = Root() / "models", camera = LoadScenario(scenario, set, false).scenario.camera;
  for (const auto& entry : fs::recursive_directory_iterator(models))
    if (entry.is_regular_file() && entry.path().extension() != ".md")
      models_[entry.path().lexically_relative(models).generic_string()] = entry.path();
  if (camera.is_absolute()) models_[camera.string()] = camera;
  for (const auto& [name, model] : models_) text_of_[model] = ReadFile(model);
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

}  // namespace kestrel
