// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace kestrel {

// The files that every flight by a scenario is read from anew: its own, and that of the gains it names.
class ScenarioFiles {
 public:
  // set: as for every flight. Throws InputError: there is no such scenario, its gains are not valid.
  ScenarioFiles(const std::string& scenario, const std::vector<std::string>& set);
  // Throws std::runtime_error: one is not as it was then.
  void RequireUnchanged() const;

 private:
  std::map<std::filesystem::path, std::string> text_of_;
};

}  // namespace kestrel
