// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/config.h"

// Where scenarios and models lie, and what to say of names that are none.
namespace kestrel {

// The folder that holds scenarios/ and models/: KESTREL_ROOT of the environment, or where the program was
// built from.
std::filesystem::path Root();

// Folders, or files of an ending, in a folder: sorted, without the ending.
std::vector<std::string> NamesIn(const std::filesystem::path& folder, const std::string& ending);
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

// The file of a camera: one of models/cameras by its name, or any file, looked for beside a folder and then
// from the working directory; its name becomes the whole path. None: there is no such, and it is a mistake.
std::optional<std::filesystem::path> CameraFile(std::string& name, const std::filesystem::path& beside,
                                                const Place& where, Mistakes& mistakes);

const ConfigNode* Find(const Config& config, std::string_view key);
// Where a key of the file was written; the file alone where it was not.
Place WhereOf(const Config& config, std::string_view key, const Place& file);

}  // namespace kestrel
