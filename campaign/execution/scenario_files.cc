// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <fmt/format.h>

#include <stdexcept>

#include "scenarios/files.h"
#include "scenarios/gains_file.h"
#include "scenarios/model_files.h"

namespace kestrel {

namespace fs = std::filesystem;

ScenarioFiles::ScenarioFiles(const std::string& scenario, const std::vector<std::string>& set) {
  const fs::path file = ScenarioFile(scenario);
  text_of_[file] = ReadFile(file);
  if (const auto gains = NamedGains(file, set).file()) text_of_[*gains] = ReadFile(*gains);
}

void ScenarioFiles::RequireUnchanged() const {
  for (const auto& [file, text] : text_of_)
    if (ReadFile(file) != text)
      throw std::runtime_error(
          fmt::format("{} was changed while it was flown by; what was flown before is kept", file.string()));
}

}  // namespace kestrel
