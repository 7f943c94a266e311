// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/diagnostics.h"

// A YAML file as a tree whose every value knows where it was written.
namespace kestrel {

// The key of a file's sentence of itself.
inline constexpr char kDescriptionKey[] = "description";

// A value in a YAML file and where it was written.
struct ConfigNode {
  enum class Kind { kNothing, kText, kList, kMap };
  Kind kind = Kind::kNothing;
  std::string text;     // of kText
  bool quoted = false;  // a quoted number is text
  Place where;
  struct Member;
  std::vector<Member> members;  // in the order of the file; the keys of a list are 0, 1, ...
};

struct ConfigNode::Member {
  std::string key;
  ConfigNode node;
};

// For messages: a text in quotes, and of the rest what kind of value it is.
std::string Shown(const ConfigNode& node);

struct Config {
  ConfigNode root;
  // The sentence by which a file says what it is, under the key `description` that each may have. It is not in
  // the root: nothing that is read from a file depends on it.
  std::string description;
  bool readable = false;  // otherwise the reason is among the mistakes, and Read leaves it at that
};

// Reads a YAML file, or YAML text under a name for its mistakes. Overrides are "key.path=value", the value
// being YAML; an element of a list is named by its number, and so is one of a vector that is not given and
// has its own value; the last of several for one key holds.
Config LoadConfig(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                  Mistakes& mistakes);
// Where a mistake in an override was made.
Place PlaceOfOverride(const std::string& text);
bool IsOverride(const Place& place);
Config ParseConfig(const std::string& text, const std::string& name,
                   const std::vector<std::string>& overrides, Mistakes& mistakes);

// Tells on standard error what is called otherwise now, once, however often the file is read.
void NoticeFormerName(const Place& where, std::string_view former, std::string_view now);

}  // namespace kestrel
