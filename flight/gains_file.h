// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/config.h"

namespace kestrel::flight {

// What a scenario's key `gains` names: a file of lines "key.path: value", which stand over what the scenario
// says itself and under what is set for a run.
class NamedGains {
 public:
  // overrides: as of the scenario; one may name the file. Throws InputError with every mistake of it.
  NamedGains(const std::filesystem::path& scenario, const std::vector<std::string>& overrides);
  const std::optional<std::filesystem::path>& file() const { return file_; }  // none: it names none
  std::vector<std::string> Under(const std::vector<std::string>& overrides) const;
  InputError Placed(const InputError& error) const;  // with the file and line of what is said of a gain

 private:
  std::optional<std::filesystem::path> file_;
  std::vector<std::string> overrides_;
  std::vector<Place> places_;  // of the overrides
};

// What load(overrides) gives, the gains that the scenario names among them. It is to pass over the key.
template <class Load>
auto LoadWithGains(const std::filesystem::path& scenario, const std::vector<std::string>& overrides,
                   const Load& load) {
  const NamedGains gains(scenario, overrides);
  try {
    return load(gains.Under(overrides));
  } catch (const InputError& e) {
    throw gains.Placed(e);
  }
}

void PassOverGains(Config& config);

}  // namespace kestrel::flight
