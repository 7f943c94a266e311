// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/sheet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>

namespace kestrel::vision {

using Kind = ConfigNode::Kind;

const ConfigNode* Find(const ConfigNode& node, std::string_view key) {
  for (const auto& [name, member] : node.members) {
    if (name == key) return &member;
  }
  return nullptr;
}

const ConfigNode* FindAny(const ConfigNode& node, const Keys& keys) {
  for (const std::string& key : keys) {
    if (const ConfigNode* found = Find(node, key)) return found;
  }
  return nullptr;
}

std::string TextOf(const ConfigNode& node, std::string_view key) {
  const ConfigNode* found = Find(node, key);
  return found ? found->text : "";
}

bool IsNumber(const ConfigNode& node, double expected) {
  double value = 0;
  const char* end = node.text.data() + node.text.size();
  const auto [rest, error] = std::from_chars(node.text.data(), end, value);
  return node.kind == Kind::kText && error == std::errc() && rest == end && value == expected;
}

Nodes ElementsOf(const ConfigNode& node) {
  if (node.kind == Kind::kText) return {&node};
  if (node.kind == Kind::kMap) {
    const ConfigNode* data = Find(node, "data");
    return data ? ElementsOf(*data) : Nodes();
  }
  Nodes all;
  for (const auto& [index, member] : node.members) {
    const Nodes of_member = ElementsOf(member);
    all.insert(all.end(), of_member.begin(), of_member.end());
  }
  return all;
}

void Sheet::Set(const std::string& key, const ConfigNode& value) { node.members.push_back({key, value}); }

void Sheet::SetText(const std::string& key, const std::string& text, const Place& where) {
  Set(key, {Kind::kText, text, false, where, {}});
}

void Sheet::SetAll(const Nodes& elements, const Keys& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) Set(keys[i], *elements[i]);
}

void Sheet::SetList(const ConfigNode& from, const std::string& key, const Keys& keys) {
  const ConfigNode* list = Find(from, key);
  if (!list && keys.empty()) return;
  if (!list) return Wrong(from.where, key, fmt::format("must be given: {}", fmt::join(keys, ", ")));
  const Nodes elements = ElementsOf(*list);
  if (elements.size() == keys.size()) return SetAll(elements, keys);
  Wrong(list->where, key, fmt::format("{} numbers are not valid", elements.size()),
        fmt::format("valid: a list of {}{}{}", keys.size(), keys.empty() ? "" : ": ", fmt::join(keys, ", ")));
}

void Sheet::SetMembers(const ConfigNode& from, const Keys& theirs, const Keys& ours) {
  Keys missing;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (const ConfigNode* found = Find(from, theirs[i]))
      Set(ours[i], *found);
    else
      missing.push_back(theirs[i]);
  }
  if (!missing.empty()) Wrong(from.where, fmt::format("{}", fmt::join(missing, ", ")), "must be given");
}

void Sheet::SetSize(const ConfigNode* width, const ConfigNode* height) {
  if (width) Set("width_px", *width);
  if (height) Set("height_px", *height);
}

void Sheet::Wrong(const Place& where, std::string_view key, const std::string& what,
                  const std::string& remedy) {
  mistakes.Add(where, path.empty() ? std::string(key) : fmt::format("{}.{}", path, key), what, remedy);
}

void Sheet::Unknown(const ConfigNode& written, std::string_view key, const Keys& valid) {
  Wrong(written.where, key, fmt::format("{} is not known", Shown(written)),
        fmt::format("valid: {}", fmt::join(valid, ", ")));
}

}  // namespace kestrel::vision
