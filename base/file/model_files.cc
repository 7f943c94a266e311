// SPDX-License-Identifier: Apache-2.0
#include "base/file/model_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/nearest_name.h"
#include "base/user_file.h"

namespace kestrel {

namespace fs = std::filesystem;

namespace {

struct ModelKind {
  const char *key, *folder;
};

ModelKind KindOf(Model model) {
  switch (model) {
    case Model::kVehicle:
      return {"vehicle", "vehicles"};
    case Model::kWorld:
      return {"world", "worlds"};
    case Model::kCamera:
      return {"camera", "cameras"};
    case Model::kPad:
      return {"pad", "pads"};
  }
  return {"", ""};
}

fs::path FileInModels(Model model, const std::string& name) {
  const fs::path folder = fs::path("models") / KindOf(model).folder;
  if (model == Model::kCamera) return DataFile(folder / (name + ".yaml"));
  const fs::path file = DataFile(folder / name) / (name + ".yaml");
  return IsFile(file) ? file : fs::path(file).replace_extension(".xml");
}

}  // namespace

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const std::string& folder : DataNames("scenarios", ""))
    for (const std::string& name : DataNames(fs::path("scenarios") / folder, ".yaml")) names.push_back(name);
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
  if (!fs::exists(DataFile("scenarios"), none))
    throw InputError("KESTREL_ROOT", fmt::format("'{}' holds no scenarios", Root().string()),
                     "valid: a folder that holds models/ and scenarios/, or not to be set");
  const fs::path file = name_or_file;
  if (IsFile(file)) return file;
  if (file.extension() == ".yaml" || file.extension() == ".yml") {
    const std::vector<std::string> names = ScenarioNames();
    if (!fs::exists(file, none) && std::find(names.begin(), names.end(), file.stem()) != names.end())
      throw InputError(name_or_file, NoSuchFile(file),
                       fmt::format("did you mean the scenario '{}'?", file.stem().string()));
    return file;
  }
  for (const std::string& folder : DataNames("scenarios", "")) {
    const fs::path candidate = DataFile(fs::path("scenarios") / folder / (name_or_file + ".yaml"));
    if (IsFile(candidate)) return candidate;
  }
  Mistakes mistakes;
  if (fs::symlink_status(file, none).type() != fs::file_type::not_found)
    mistakes.Add("kestrel", "scenario", NoSuchFile(file));  // a folder, a pipe, a name too long
  else
    Known("scenario", name_or_file, ScenarioNames(), "kestrel", mistakes);
  throw InputError(mistakes.all());
}

std::vector<std::string> ModelNames(Model model) {
  return DataNames(fs::path("models") / KindOf(model).folder, model == Model::kCamera ? ".yaml" : "");
}

std::optional<fs::path> ModelFile(Model model, std::string& name, const fs::path& beside, const Place& where,
                                  Mistakes& mistakes) {
  const std::vector<std::string> names = ModelNames(model);
  if (std::find(names.begin(), names.end(), name) != names.end()) return FileInModels(model, name);
  for (const fs::path& candidate : {beside / name, fs::path(name)}) {
    if (!IsFile(candidate)) continue;
    // Beside a vehicle's numbers lie files of other kinds with its name.
    if ((model == Model::kVehicle || model == Model::kWorld) && !HasEnding(name, {".yaml", ".xml"})) {
      mistakes.Add(where, KindOf(model).key,
                   fmt::format("'{}' ends in neither .yaml nor .xml", candidate.string()),
                   fmt::format("valid: the file of a {}, NAME.yaml or NAME.xml", KindOf(model).key));
      return std::nullopt;
    }
    name = fs::absolute(candidate).lexically_normal().string();
    return name;
  }
  const std::string what = KindOf(model).key, key = where == Place("--camera") ? "" : what;
  if (name.find('/') != std::string::npos || HasEnding(name, {".yaml", ".yml", ".xml"})) {
    mistakes.Add(where, key, NoSuchFile(name));
  } else {
    mistakes.Add(where, key, fmt::format("there is no {} '{}'", what, name), RemedyForName(name, names));
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
