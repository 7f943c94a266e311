// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/config.h"

#include <fmt/format.h>
#include <yaml-cpp/exceptions.h>

#include <algorithm>
#include <boost/locale/utf.hpp>
#include <cstdio>
#include <mutex>
#include <set>
#include <sstream>

#include "base/printable.h"
#include "base/user_file.h"
#include "base/yaml/yaml_nodes.h"

namespace kestrel {
namespace {

using Kind = ConfigNode::Kind;

// The number of the first line that is not UTF-8, in which alone others read what is kept of a file. 0: all
// are.
int LineNotUtf8(const std::string& text) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  int line = 1;
  for (auto at = text.begin(); at != text.end();) {
    const auto letter = Utf8::decode(at, text.end());
    if (letter == boost::locale::utf::illegal || letter == boost::locale::utf::incomplete) return line;
    line += letter == '\n';
  }
  return 0;
}

void Override(ConfigNode& root, const std::string& text, Mistakes& mistakes) {
  const Place where = PlaceOfOverride(text);
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return mistakes.Add(where, "", "not of the form key.path=value");
  ConfigNode value;
  try {
    value = ReadNodes(text.substr(equals + 1), [&](int) { return where; });
  } catch (const YAML::Exception& e) {
    return mistakes.Add(where, text.substr(0, equals), "the value is not valid YAML: " + e.msg);
  }

  ConfigNode* node = &root;
  std::istringstream path(text.substr(0, equals));
  std::string walked;
  for (std::string key; std::getline(path, key, '.');) {
    if (node->kind == Kind::kText)
      return mistakes.Add(where, walked, "is a single value: it has no keys below it");
    walked += (walked.empty() ? "" : ".") + key;
    // The last of equal keys is the one that a repeated override means; in a file they are refused anyway.
    const auto found = std::find_if(node->members.rbegin(), node->members.rend(),
                                    [&](const auto& member) { return member.key == key; });
    if (found != node->members.rend()) {
      node = &found->node;
    } else if (node->kind == Kind::kList) {
      return mistakes.Add(where, walked,
                          fmt::format("the list has {} elements, counted from 0", node->members.size()));
    } else {
      node->kind = Kind::kMap;
      node->members.push_back({key, {Kind::kNothing, "", false, where, {}}});
      node = &node->members.back().node;
    }
  }
  *node = std::move(value);
}

void TakeDescription(Config& config, Mistakes& mistakes) {
  constexpr std::size_t kLongest = 200;
  std::vector<ConfigNode::Member>& members = config.root.members;
  if (config.root.kind != Kind::kMap) return;
  const auto found = std::find_if(members.begin(), members.end(),
                                  [](const auto& member) { return member.key == kDescriptionKey; });
  if (found == members.end()) return;
  const ConfigNode& node = found->node;
  if (node.kind != Kind::kText || node.text.empty() || node.text.size() > kLongest || HasControl(node.text))
    mistakes.Add(node.where, kDescriptionKey, Shown(node) + " is not valid",
                 fmt::format("valid: a sentence of up to {} bytes in one line", kLongest));
  else
    config.description = node.text;
  members.erase(found);
}

}  // namespace

std::string Shown(const ConfigNode& node) {
  switch (node.kind) {
    case Kind::kNothing:
      return "nothing";
    case Kind::kText:
      return node.text.size() <= 200 ? '\'' + node.text + '\'' : '\'' + node.text.substr(0, 100) + "'...";
    case Kind::kList:
      return fmt::format("a list of {}", node.members.size());
    case Kind::kMap:
      return "a map";
  }
  return "";
}

Place PlaceOfOverride(const std::string& text) { return "--set " + text; }
bool IsOverride(const Place& place) { return place.file.starts_with("--set "); }

Config LoadConfig(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                  Mistakes& mistakes) {
  const FileContent content = ReadUserFile(file, kMaxTextBytes);
  if (!content.error.empty()) {
    mistakes.Add(file.string(), "", content.error);
    return {};
  }
  return ParseConfig(content.bytes, file.string(), overrides, mistakes);
}

Config ParseConfig(const std::string& text, const std::string& name,
                   const std::vector<std::string>& overrides, Mistakes& mistakes) {
  Config config;
  const auto where_of = [&](int line) { return Place(name, line + 1); };
  if (const int line = LineNotUtf8(text); line > 0) {
    mistakes.Add({name, line}, "", "it is not in UTF-8", "valid: the file saved in UTF-8");
    return config;
  }
  try {
    config.root = ReadNodes(text, where_of);
    config.readable = true;
    TakeDescription(config, mistakes);
  } catch (const YAML::Exception& e) {
    mistakes.Add(where_of(e.mark.line), "", "not valid YAML: " + e.msg);
    return config;
  }
  for (const std::string& each : overrides) Override(config.root, each, mistakes);
  return config;
}

void NoticeFormerName(const Place& where, std::string_view former, std::string_view now) {
  static std::mutex mutex;
  static std::set<std::string> told;
  const std::string notice = fmt::format("{}: {}: is called '{}' now", where.Text(), former, now);
  const std::lock_guard lock(mutex);
  if (told.insert(notice).second) std::fputs(("kestrel: " + Printable(notice) + "\n").c_str(), stderr);
}

}  // namespace kestrel
