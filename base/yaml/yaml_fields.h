// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/config.h"
#include "base/yaml/fields.h"

// Parameter structs to and from YAML, checked: the visitors of the Fields that base/yaml/fields.h describes.
// What has no key in the file keeps the value that it had.
namespace kestrel {

// What is wrong with a key that no field has.
inline constexpr std::string_view kUnknownKey = "unknown key";

// The visitor that fills a struct from a map.
class FieldReader final : public FieldVisitor {
 public:
  FieldReader(const ConfigNode& node, std::string path, Mistakes& mistakes);
  void Visit(const FieldKey& key, const FieldValue& field) override;
  // After all fields: refuses the keys that none of them has.
  void Finish() const;

 private:
  void Read(const FieldKey& key, const NumberField& field);
  void Read(const FieldKey& key, const OptionalNumberField& field);
  void Read(const FieldKey& key, const IntegerField& field);
  void Read(const FieldKey& key, const SeedField& field);
  void Read(const FieldKey& key, const FlagField& field);
  void Read(const FieldKey& key, const TextField& field);
  void Read(const FieldKey& key, const TextsField& field);
  void Read(const FieldKey& key, const NumbersField& field);
  void Read(const FieldKey& key, const NodeField& field);
  void Read(const FieldKey& key, const StructField& field);
  void Read(const FieldKey& key, const StructsField& field);

  const ConfigNode* Find(const FieldKey& key);  // null when not given
  std::string Path(std::string_view key) const;
  bool Holds(const ConfigNode& node, ConfigNode::Kind kind, const FieldKey& key) const;
  void Wrong(const ConfigNode& node, std::string_view key, std::string_view what,
             std::string_view remedy = {}) const;
  bool Number(const ConfigNode& node, std::string_view key, double low, double high, double& value) const;
  void Nested(const ConfigNode& node, const std::string& path, const StructField& field);
  void RefuseRepeated(const ConfigNode& node, const std::string& path) const;

  const ConfigNode& node_;
  std::string path_;
  Mistakes& mistakes_;
  std::vector<std::string> keys_, former_keys_;
};

// The visitor that writes a struct as YAML. Numbers read back to the same bits.
class FieldWriter final : public FieldVisitor {
 public:
  explicit FieldWriter(int indent = 0) : indent_(indent) {}
  void Visit(const FieldKey& key, const FieldValue& field) override;
  const std::string& text() const { return text_; }

 private:
  static std::string Nested(const StructField& field, int indent);
  void Write(std::string_view key, const StructsField& field);
  std::string AsListItem(std::string block) const;
  void Line(std::string_view key, std::string_view value);
  void Block(std::string_view key, const std::string& block, const char* empty);

  int indent_;
  std::string text_;
};

// Fills a struct from a file; every mistake is gathered, and fields with one keep the value that they had.
template <class T>
void Read(const Config& config, T& into, Mistakes& mistakes) {
  if (!config.readable) return;
  FieldReader reader(config.root, "", mistakes);
  Fields(reader, into);
  reader.Finish();
}

template <class T>
std::string ToYaml(T value) {
  FieldWriter writer;
  Fields(writer, value);
  return writer.text();
}

}  // namespace kestrel
