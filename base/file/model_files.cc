// SPDX-License-Identifier: Apache-2.0
#include "base/file/model_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include "base/diagnostics.h"
#include "base/nearest_name.h"
#include "base/user_file.h"

namespace kestrel {

namespace fs = std::filesystem;

fs::path Root() {
  const char* root = std::getenv("KESTREL_ROOT");
  return root && *root ? fs::path(root) : fs::path(KESTREL_SOURCE_DIR);
}

std::vector<std::string> NamesIn(const fs::path& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (ending.empty() ? entry.is_directory() : entry.path().extension() == ending) {
      names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const std::string& folder : NamesIn(Root() / "scenarios", "")) {
    for (const std::string& name : NamesIn(Root() / "scenarios" / folder, ".yaml")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool Known(const std::string& what, const std::string& name, const std::vector<std::string>& names,
           const Place& where, Mistakes& mistakes) {
  if (std::find(names.begin(), names.end(), name) != names.end()) return true;
  mistakes.Add(where, what, fmt::format("there is no {} '{}'", what, name), RemedyForName(name, names));
  return false;
}

void NoMoreThan::operator()(const std::string& key, double value, double limit,
                            const std::string& limit_key) const {
  if (value > limit)
    mistakes.Add(where, key, fmt::format("{:g}, and {} is {:g}", value, limit_key, limit),
                 "valid: no more than that");
}

fs::path ScenarioFile(const std::string& name_or_file) {
  std::error_code none;
  if (!fs::exists(Root() / "scenarios", none))
    throw InputError("KESTREL_ROOT", fmt::format("'{}' holds no scenarios", Root().string()));
  const fs::path file = name_or_file;
  if (file.extension() == ".yaml" || file.extension() == ".yml" || IsFile(file)) return file;
  for (const std::string& folder : NamesIn(Root() / "scenarios", "")) {
    const fs::path candidate = Root() / "scenarios" / folder / (name_or_file + ".yaml");
    if (IsFile(candidate)) return candidate;
  }
  Mistakes mistakes;
  if (fs::symlink_status(file, none).type() != fs::file_type::not_found)
    mistakes.Add("kestrel", "scenario", NoSuchFile(file));  // a folder, a pipe, a name too long
  else
    Known("scenario", name_or_file, ScenarioNames(), "kestrel", mistakes);
  throw InputError(mistakes.all());
}

std::optional<fs::path> CameraFile(std::string& name, const fs::path& beside, const Place& where,
                                   Mistakes& mistakes) {
  const fs::path folder = Root() / "models" / "cameras";
  const std::vector<std::string> names = NamesIn(folder, ".yaml");
  if (std::find(names.begin(), names.end(), name) != names.end()) return folder / (name + ".yaml");
  for (const fs::path& candidate : {beside / name, fs::path(name)}) {
    if (!IsFile(candidate)) continue;
    name = fs::absolute(candidate).lexically_normal().string();
    return name;
  }
  const std::string key = where == Place("--camera") ? "" : "camera";
  if (name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml")) {
    mistakes.Add(where, key, NoSuchFile(name));
  } else {
    mistakes.Add(where, key, fmt::format("there is no camera '{}'", name), RemedyForName(name, names));
  }
  return std::nullopt;
}

const ConfigNode* Find(const Config& config, std::string_view key) {
  for (const auto& [name, node] : config.root.members) {
    if (name == key) return &node;
  }
  return nullptr;
}

Place WhereOf(const Config& config, std::string_view key, const Place& file) {
  const ConfigNode* node = Find(config, key);
  return node ? node->where : file;
}

}  // namespace kestrel
