// SPDX-License-Identifier: Apache-2.0
#include "app/files/schema_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/files/field_text.h"
#include "app/option/one_of.h"

namespace kestrel::app {
namespace {

using Json = nlohmann::ordered_json;
Json Properties(const std::vector<FieldDescription>& fields);

// No key but these.
Json Object(const std::vector<FieldDescription>& fields) {
  Json object = {{"type", "object"}, {"properties", Properties(fields)}, {"additionalProperties", false}};
  for (const FieldDescription& each : fields)
    if (each.required) object["required"].push_back(each.key);
  return object;
}

void AddRange(const FieldDescription& f, Json& schema) {
  if (f.low) schema["minimum"] = *f.low;
  if (f.high) schema["maximum"] = *f.high;
}

Json Schema(const FieldDescription& f) {
  Json schema = Json::object();
  switch (f.kind) {
    case FieldKind::kNumber:
    case FieldKind::kInteger:
      schema["type"] = f.kind == FieldKind::kNumber ? "number" : "integer";
      AddRange(f, schema);
      break;
    case FieldKind::kSeed:
      schema = {{"type", "integer"}, {"minimum", 0}};
      break;
    case FieldKind::kFlag:
      schema["type"] = "boolean";
      break;
    case FieldKind::kText:
      schema["type"] = "string";
      if (!f.valid.empty()) schema["enum"] = f.valid;
      break;
    case FieldKind::kTexts:
      schema = {{"type", "array"}, {"items", {{"type", "string"}}}};
      break;
    case FieldKind::kNumbers: {
      Json item = {{"type", "number"}};
      AddRange(f, item);
      schema = {{"type", "array"}, {"items", item}, {"minItems", f.size}, {"maxItems", f.size}};
      break;
    }
    case FieldKind::kAny:
      break;
    case FieldKind::kStruct:
      schema = Object(f.fields);
      break;
    case FieldKind::kList:
      schema = {{"type", "array"}, {"items", Object(f.fields)}};
      break;
    case FieldKind::kMap:
      schema = {{"type", "object"}, {"additionalProperties", Object(f.fields)}};
      break;
  }
  if (f.nullable) schema["type"] = {schema["type"], "null"};
  if (!f.meaning.empty()) schema["description"] = AsSentence(f.meaning);
  if (Json value = Json::parse(f.value, nullptr, false); !f.value.empty() && !value.is_discarded())
    schema["default"] = std::move(value);
  else if (f.kind == FieldKind::kText && !f.value.empty())
    schema["default"] = f.value;
  return schema;
}

Json Properties(const std::vector<FieldDescription>& fields) {
  Json properties = Json::object();
  for (const FieldDescription& each : fields) {
    properties[each.key] = Schema(each);
    if (each.former.empty()) continue;
    properties[each.former] = properties[each.key];
    properties[each.former]["deprecated"] = true;
  }
  return properties;
}

}  // namespace

CLI::App* AddSchemaCommand(CLI::App& app, SchemaArguments& a) {
  CLI::App* command =
      app.add_subcommand("schema", "Print the JSON Schema of a kind of file, for editors that take one");
  command->add_option("kind", a.kind, "Of what")->required()->check(OneOf(FileKindNames()));
  command->footer("Example:\n  kestrel schema scenario > scenario.schema.json");
  return command;
}

std::string JsonSchema(const FileKind& kind) {
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", "Kestrel " + kind.name},
                 {"description", AsSentence(kind.summary)}};
  const std::vector<FieldDescription> common = CommonFields(kind);
  schema.update(Object(common));
  // What one of the variants has alone.
  for (const FileKind::Variant& variant : kind.variants) {
    const std::vector<FieldDescription> own = OwnFields(kind, variant);
    if (own.empty()) continue;
    Json names = Json::array();
    for (const FieldDescription& each : variant.fields) names.push_back(each.key);
    for (const FieldDescription& each : own)
      if (!schema["properties"].contains(each.key)) schema["properties"][each.key] = Json::object();
    Json then = {{"properties", Properties(own)}, {"propertyNames", {{"enum", names}}}};
    for (const FieldDescription& each : own)
      if (each.required) then["required"].push_back(each.key);
    Json selected = {{"properties", {{kind.selector, {{"const", variant.name}}}}}};
    // Without the selector the first variant is meant.
    if (&variant != &kind.variants.front()) selected["required"] = {kind.selector};
    schema["allOf"].push_back({{"if", selected}, {"then", then}});
  }
  return schema.dump(2) + '\n';
}

void SchemaCommand(const SchemaArguments& a) { fmt::print("{}", JsonSchema(FileKindNamed(a.kind))); }

}  // namespace kestrel::app
