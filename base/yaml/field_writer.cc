// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "base/overloaded.h"
#include "base/yaml/quoted.h"
#include "base/yaml/yaml_fields.h"
#include "base/yaml/yaml_nodes.h"

namespace kestrel {
namespace {

std::string QuotedIfNeeded(const std::string& text) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || std::strchr("_./-", c); };
  static const std::vector<std::string> kSpecial = {"true", "false", "null", "yes", "no", "on", "off"};
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!text.empty() && (std::isalpha(static_cast<unsigned char>(text[0])) || text[0] == '_') &&
      text.find('\0') == std::string::npos && std::all_of(text.begin(), text.end(), plain) &&
      std::find(kSpecial.begin(), kSpecial.end(), lower) == kSpecial.end()) {
    return text;
  }
  return Quoted(text);
}

}  // namespace

void FieldWriter::Visit(const FieldKey& key, const FieldValue& field) {
  const auto line = [&](std::string_view value) { Line(key.name, value); };
  const auto number = [](double value) { return fmt::format("{}", value); };
  std::visit(Overloaded{
                 [&](const NumberField& f) { line(number(*f.value)); },
                 [&](const OptionalNumberField& f) { line(*f.value ? number(**f.value) : "null"); },
                 [&](const IntegerField& f) { line(fmt::format("{}", *f.value)); },
                 [&](const SeedField& f) { line(fmt::format("{}", *f.value)); },
                 [&](const FlagField& f) { line(*f.value ? "true" : "false"); },
                 [&](const TextField& f) { line(QuotedIfNeeded(*f.value)); },
                 [&](const TextsField& f) {
                   std::string items;
                   for (const std::string& text : *f.value)
                     items += fmt::format("{:{}}- {}\n", "", 2 * (indent_ + 1), QuotedIfNeeded(text));
                   Block(key.name, items, "[]");
                 },
                 [&](const NumbersField& f) {
                   line(fmt::format("[{}]", fmt::join(f.values, f.values + f.size, ", ")));
                 },
                 [&](const NodeField& f) { line(FlowText(*f.value)); },
                 [&](const StructField& f) { Block(key.name, Nested(f, indent_ + 1), "{}"); },
                 [&](const StructsField& f) { Write(key.name, f); },
             },
             field);
}

void FieldWriter::Write(std::string_view key, const StructsField& field) {
  const auto all = field.all(field.value);
  switch (field.kind) {
    case StructsField::Kind::kOptional:
      return all.empty() ? Line(key, "null") : Block(key, Nested(all.front().second, indent_ + 1), "{}");
    case StructsField::Kind::kList: {
      std::string items;
      for (const auto& [name, each] : all) items += AsListItem(Nested(each, indent_ + 2));
      return Block(key, items, "[]");
    }
    case StructsField::Kind::kMap: {
      FieldWriter members(indent_ + 1);
      for (const auto& [name, each] : all) members.Block(name, Nested(each, indent_ + 2), "{}");
      return Block(key, members.text_, "{}");
    }
  }
}

std::string FieldWriter::Nested(const StructField& field, int indent) {
  FieldWriter writer(indent);
  field.Visit(writer);
  return writer.text_;
}

void FieldWriter::Line(std::string_view key, std::string_view value) {
  text_ += fmt::format("{:{}}{}: {}\n", "", 2 * indent_, QuotedIfNeeded(std::string(key)), value);
}

void FieldWriter::Block(std::string_view key, const std::string& block, const char* empty) {
  if (block.empty()) return Line(key, empty);
  text_ += fmt::format("{:{}}{}:\n{}", "", 2 * indent_, QuotedIfNeeded(std::string(key)), block);
}

std::string FieldWriter::AsListItem(std::string block) const {
  const std::size_t dash = 2 * (indent_ + 1);
  if (block.empty()) return fmt::format("{:{}}- {{}}\n", "", dash);
  return block[dash] = '-', block;
}

}  // namespace kestrel
