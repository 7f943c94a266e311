// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "base/nearest_name.h"
#include "base/yaml/yaml_fields.h"

namespace kestrel {
namespace {

using Kind = ConfigNode::Kind;

enum class Parsed { kNumber, kNotFinite, kNotANumber };

Parsed ParseNumber(const ConfigNode& node, double& value) {
  if (node.kind != Kind::kText || node.quoted) return Parsed::kNotANumber;
  std::string_view text = node.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  std::string_view magnitude = text;
  if (!magnitude.empty() && magnitude[0] == '-') magnitude.remove_prefix(1);
  std::string lower(magnitude);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (lower == ".inf" || lower == "inf" || lower == ".nan" || lower == "nan") return Parsed::kNotFinite;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) return Parsed::kNotFinite;
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? Parsed::kNumber : Parsed::kNotANumber;
}

}  // namespace

FieldReader::FieldReader(const ConfigNode& node, std::string path, Mistakes& mistakes)
    : node_(node), path_(std::move(path)), mistakes_(mistakes) {
  RefuseRepeated(node_, path_);
}

void FieldReader::Visit(const FieldKey& key, const FieldValue& field) {
  std::visit([&](const auto& of_kind) { Read(key, of_kind); }, field);
}

const ConfigNode* FieldReader::Find(const FieldKey& key) {
  keys_.push_back(key.name);
  const auto last = [this](std::string_view name) -> const ConfigNode* {
    for (auto it = node_.members.rbegin(); it != node_.members.rend(); ++it)
      if (it->key == name) return &it->node;
    return nullptr;
  };
  if (node_.kind == Kind::kMap) {
    const ConfigNode* now = last(key.name);
    const ConfigNode* before = key.former ? last(key.former) : nullptr;
    if (before) {
      former_keys_.push_back(key.former);
      if (now)
        Wrong(*before, key.former, fmt::format("is the former name of '{}', which is given too", key.name),
              "valid: one of the two");
      else
        NoticeFormerName(before->where, Path(key.former), key.name);
    }
    if (now || before) return now ? now : before;
  }
  if (key.required && (node_.kind == Kind::kMap || node_.kind == Kind::kNothing)) {
    mistakes_.Add(node_.where, Path(key.name), "must be given");
  }
  return nullptr;
}

std::string FieldReader::Path(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

bool FieldReader::Holds(const ConfigNode& node, Kind kind, const FieldKey& key) const {
  if (node.kind == kind || node.kind == Kind::kNothing) return true;
  Wrong(node, key.name, fmt::format("{} is not a {}", Shown(node), kind == Kind::kList ? "list" : "map"));
  return false;
}

void FieldReader::Wrong(const ConfigNode& node, std::string_view key, std::string_view what,
                        std::string_view remedy) const {
  mistakes_.Add(node.where, Path(key), what, remedy);
}

bool FieldReader::Number(const ConfigNode& node, std::string_view key, double low, double high,
                         double& value) const {
  const auto wrong = [&](const std::string& what) {
    Wrong(node, key, what, fmt::format("valid: {} to {}", low, high));
    return false;
  };
  double number = 0;
  switch (ParseNumber(node, number)) {
    case Parsed::kNotANumber:
      return wrong(Shown(node) + " is not a number");
    case Parsed::kNotFinite:
      return wrong(node.text + " is not a finite number");
    case Parsed::kNumber:
      break;
  }
  if (!(number >= low && number <= high)) return wrong(node.text + " is out of range");
  value = number;
  return true;
}

void FieldReader::Read(const FieldKey& key, const NumberField& field) {
  if (const ConfigNode* node = Find(key)) Number(*node, key.name, field.low, field.high, *field.value);
}

void FieldReader::Read(const FieldKey& key, const OptionalNumberField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind == Kind::kNothing) return field.value->reset();
  double number = 0;
  if (Number(*node, key.name, field.low, field.high, number)) *field.value = number;
}

void FieldReader::Read(const FieldKey& key, const IntegerField& field) {
  const ConfigNode* node = Find(key);
  double number = 0;
  if (!node || !Number(*node, key.name, field.low, field.high, number)) return;
  if (number != std::floor(number)) {
    return Wrong(*node, key.name, node->text + " is not a whole number",
                 fmt::format("valid: {} to {}", field.low, field.high));
  }
  *field.value = static_cast<int>(number);
}

void FieldReader::Read(const FieldKey& key, const SeedField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  std::uint64_t number = 0;
  const char* last = node->text.data() + node->text.size();
  const auto [end, error] = std::from_chars(node->text.data(), last, number);
  if (node->kind != Kind::kText || node->quoted || error != std::errc() || end != last) {
    return Wrong(*node, key.name, Shown(*node) + " is not valid",
                 fmt::format("valid: a whole number, 0 to {}", UINT64_MAX));
  }
  *field.value = number;
}

void FieldReader::Read(const FieldKey& key, const FlagField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind != Kind::kText || node->quoted || (node->text != "true" && node->text != "false"))
    return Wrong(*node, key.name, Shown(*node) + " is not valid", "valid: true, false");
  *field.value = node->text == "true";
}

void FieldReader::Read(const FieldKey& key, const TextField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (!field.valid && node->kind != Kind::kText)
    return Wrong(*node, key.name, Shown(*node) + " is not a text");
  if (field.valid && (node->kind != Kind::kText || std::find(field.valid->begin(), field.valid->end(),
                                                             node->text) == field.valid->end())) {
    const auto nearest = NearestName(node->text, *field.valid);
    return Wrong(*node, key.name, Shown(*node) + " is not valid",
                 fmt::format("{}valid: {}", nearest ? fmt::format("did you mean '{}'? ", *nearest) : "",
                             fmt::join(*field.valid, ", ")));
  }
  *field.value = node->text;
}

void FieldReader::Read(const FieldKey& key, const TextsField& field) {
  const ConfigNode* node = Find(key);
  if (!node || !Holds(*node, Kind::kList, key)) return;
  field.value->clear();
  for (const auto& [index, member] : node->members) {
    if (member.kind == Kind::kText)
      field.value->push_back(member.text);
    else
      Wrong(member, fmt::format("{}.{}", key.name, index), Shown(member) + " is not a text");
  }
}

void FieldReader::Read(const FieldKey& key, const NumbersField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  const auto is_element = [&](const auto& member) {
    for (int i = 0; i < field.size; ++i)
      if (member.key == std::to_string(i)) return true;
    return false;
  };
  const bool some = node->kind == Kind::kMap && !node->members.empty() &&
                    std::all_of(node->members.begin(), node->members.end(), is_element);
  if (!some && (node->kind != Kind::kList || node->members.size() != static_cast<std::size_t>(field.size))) {
    return Wrong(
        *node, key.name, Shown(*node) + " is not valid",
        fmt::format("valid: a list of {} numbers, each {} to {}", field.size, field.low, field.high));
  }
  std::vector<double> read(field.values, field.values + field.size);
  bool all = true;
  for (const auto& [index, member] : node->members) {
    all &=
        Number(member, fmt::format("{}.{}", key.name, index), field.low, field.high, read[std::stoul(index)]);
  }
  if (all) std::copy(read.begin(), read.end(), field.values);
}

void FieldReader::Read(const FieldKey& key, const NodeField& field) {
  if (const ConfigNode* node = Find(key)) *field.value = *node;
}

void FieldReader::Read(const FieldKey& key, const StructField& field) {
  const ConfigNode nothing{Kind::kNothing, "", false, node_.where, {}};
  const ConfigNode* node = Find(key);
  Nested(node ? *node : nothing, Path(key.name), field);
}

void FieldReader::Read(const FieldKey& key, const StructsField& field) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  const std::string path = Path(key.name);
  if (field.kind == StructsField::Kind::kOptional) {
    if (node->kind == Kind::kNothing) return field.clear(field.value);
    const auto is = field.all(field.value);
    return Nested(*node, path, is.empty() ? field.add(field.value, "") : is.front().second);
  }
  const bool list = field.kind == StructsField::Kind::kList;
  if (!Holds(*node, list ? Kind::kList : Kind::kMap, key)) return;
  field.clear(field.value);
  if (!list) RefuseRepeated(*node, path);
  for (const auto& [name, member] : node->members)
    Nested(member, path + '.' + name, field.add(field.value, name));
}

void FieldReader::Nested(const ConfigNode& node, const std::string& path, const StructField& field) {
  FieldReader reader(node, path, mistakes_);
  field.Visit(reader);
  reader.Finish();
}

void FieldReader::RefuseRepeated(const ConfigNode& node, const std::string& path) const {
  if (node.kind != Kind::kMap) return;
  std::unordered_map<std::string_view, const Place*> first;
  for (const auto& [key, member] : node.members) {
    const auto [before, is_new] = first.emplace(key, &member.where);
    if (is_new) continue;
    mistakes_.Add(member.where, path.empty() ? key : path + '.' + key,
                  "given twice, first at " + before->second->Text());
  }
}

void FieldReader::Finish() const {
  if (node_.kind == Kind::kText || node_.kind == Kind::kList) {
    return mistakes_.Add(node_.where, path_, Shown(node_) + " is not valid",
                         fmt::format("valid: a map of {}", fmt::join(keys_, ", ")));
  }
  for (const auto& [key, member] : node_.members) {
    if (std::find(keys_.begin(), keys_.end(), key) != keys_.end() ||
        std::find(former_keys_.begin(), former_keys_.end(), key) != former_keys_.end())
      continue;
    std::vector<std::string> valid = keys_;
    if (path_.empty()) valid.push_back(kDescriptionKey);
    const auto nearest = NearestName(key, valid);
    Wrong(member, key, kUnknownKey, RemedyForName(key, nearest ? valid : keys_));
  }
}

}  // namespace kestrel
