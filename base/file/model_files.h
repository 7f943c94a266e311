// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/file/data_folders.h"
#include "base/yaml/config.h"

// Scenarios and models by their names, and what to say of names that are none.
namespace kestrel {

std::vector<std::string> ScenarioNames();

// Whether a name is one of those that there are; otherwise says so, with the nearest or all of them.
bool Known(const std::string& what, const std::string& name, const std::vector<std::string>& names,
           const Place& where, Mistakes& mistakes);

// Refuses a value above another.
struct NoMoreThan {
  const Place& where;
  Mistakes& mistakes;
  void operator()(const std::string& key, double value, double limit, const std::string& limit_key) const;
};

// The file of a scenario by its name in scenarios/, or any YAML file. Throws InputError: there is none.
std::filesystem::path ScenarioFile(const std::string& name_or_file);

// What models/ holds. A vehicle, a world and a pad are a folder there, with files of the same name.
enum class Model { kVehicle, kWorld, kCamera, kPad };
std::vector<std::string> ModelNames(Model model);

// The file of a model: of one in models/ by its name, or any file, looked for beside a folder and then from
// the working directory; its name becomes the whole path. In a folder NAME/ it is NAME.yaml, or NAME.xml where
// there is none. None: there is no such, and it is a mistake.
std::optional<std::filesystem::path> ModelFile(Model model, std::string& name,
                                               const std::filesystem::path& beside, const Place& where,
                                               Mistakes& mistakes);

const ConfigNode* Find(const Config& config, std::string_view key);
// Where a key of the file was written; the file alone where it was not.
Place WhereOf(const Config& config, std::string_view key, const Place& file);

}  // namespace kestrel
