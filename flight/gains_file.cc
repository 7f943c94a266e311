// SPDX-License-Identifier: Apache-2.0
#include "flight/gains_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/user_file.h"

namespace kestrel::flight {

namespace fs = std::filesystem;

NamedGains::NamedGains(const fs::path& scenario, const std::vector<std::string>& overrides) {
  Mistakes mistakes, others;
  const Config config = LoadConfig(scenario, overrides, others);
  const ConfigNode* named = config.readable ? Find(config, "gains") : nullptr;
  if (!named || named->kind == ConfigNode::Kind::kNothing) return;
  fs::path file = scenario.parent_path() / named->text;
  if (!IsFile(file)) file = named->text;
  if (!IsFile(file)) {
    mistakes.Add(named->where, "gains", NoSuchFile(named->text),
                 "valid: one beside the scenario or from here");
    mistakes.ThrowIfAny();
  }
  file_ = file;
  const Config read = LoadConfig(file, {}, mistakes);
  if (read.readable && read.root.kind != ConfigNode::Kind::kMap)
    mistakes.Add(read.root.where, "", "holds no gains", "valid: lines of key.path: value");
  std::map<std::string, Place> first;
  for (const auto& [key, node] : read.root.members) {
    if (const auto [there, is_new] = first.emplace(key, node.where); !is_new)
      mistakes.Add(node.where, key, "given twice, first at " + there->second.Text());
    if (key == "gains")
      mistakes.Add(node.where, key, "a file of gains names no other", "valid: lines of key.path: value");
    else if (node.kind != ConfigNode::Kind::kText)
      mistakes.Add(node.where, key, "is not a single value", "valid: lines of key.path: value");
    overrides_.push_back(key + '=' + node.text);
    places_.push_back(node.where);
  }
  mistakes.ThrowIfAny();
}

std::vector<std::string> NamedGains::Under(const std::vector<std::string>& overrides) const {
  std::vector<std::string> all = overrides_;
  all.insert(all.end(), overrides.begin(), overrides.end());
  return all;
}

InputError NamedGains::Placed(const InputError& error) const {
  std::vector<Diagnostic> placed = error.diagnostics;
  for (Diagnostic& each : placed) {
    const auto of = std::find_if(overrides_.begin(), overrides_.end(), [&](const std::string& override) {
      return each.place() == PlaceOfOverride(override);
    });
    if (of == overrides_.end()) continue;
    const Place& place = places_[static_cast<std::size_t>(of - overrides_.begin())];
    each.file = place.file;
    each.line = place.line;
  }
  return InputError(std::move(placed));
}

void PassOverGains(Config& config) {
  std::erase_if(config.root.members, [](const auto& member) { return member.key == "gains"; });
}

}  // namespace kestrel::flight
