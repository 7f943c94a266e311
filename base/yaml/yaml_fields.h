// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/yaml/fields.h"

// Parameter structs to and from YAML, checked: the visitors of the Fields that base/yaml/fields.h describes.
// They understand: double, int, std::uint64_t, bool, std::string, Eigen vectors of fixed size with the range
// of their elements, std::optional<double>, and structs with Fields, alone or in std::optional, std::vector
// or std::map by free names; the reader also lists of texts, and nodes that no struct describes, as they
// stand. What has no key in the file keeps the value that it had.
namespace kestrel {

// Bad input, every mistake of it: one per line in what().
struct InputError : std::runtime_error {
  explicit InputError(std::vector<std::string> all);
  std::vector<std::string> messages;
};

// Gathers the mistakes of several files and overrides before any is reported.
class Mistakes {
 public:
  // where: "path/file.yaml:12" or "--set key=value"; key: dotted, may be empty.
  void Add(std::string_view where, std::string_view key, std::string_view what);
  const std::vector<std::string>& messages() const { return messages_; }
  void ThrowIfAny() const;

 private:
  std::vector<std::string> messages_;
};

// A value in a YAML file and where it was written.
struct ConfigNode {
  enum class Kind { kNothing, kText, kList, kMap };
  Kind kind = Kind::kNothing;
  std::string text;     // of kText
  bool quoted = false;  // a quoted number is text
  std::string where;    // as for Mistakes
  std::vector<std::pair<std::string, ConfigNode>>
      members;  // in the order of the file; the keys of a list are 0, 1, ...
};

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
Config ParseConfig(const std::string& text, const std::string& name,
                   const std::vector<std::string>& overrides, Mistakes& mistakes);

// The one of the valid names that a misspelt one most likely stands for, if any is near.
std::optional<std::string> NearestName(std::string_view name, const std::vector<std::string>& valid);

// The visitor that fills a struct from a map.
class FieldReader {
 public:
  FieldReader(const ConfigNode& node, std::string path, Mistakes& mistakes);

  void operator()(FieldKey key, double& value, double low, double high);
  void operator()(FieldKey key, std::optional<double>& value, double low, double high);
  void operator()(FieldKey key, int& value, int low, int high);
  void operator()(FieldKey key, std::uint64_t& value);
  void operator()(FieldKey key, bool& value);
  void operator()(FieldKey key, std::string& value);
  void operator()(FieldKey key, std::string& value, std::initializer_list<const char*> valid);
  void operator()(FieldKey key, std::string& value, const std::vector<std::string>& valid);
  void operator()(FieldKey key, std::vector<std::string>& value);
  void operator()(FieldKey key, ConfigNode& value);
  template <int size>
  void operator()(FieldKey key, Eigen::Matrix<double, size, 1>& value, double low, double high) {
    static_assert(size > 0);
    Numbers(key, value.data(), size, low, high);
  }
  template <class T>
  void operator()(FieldKey key, T& value) {
    const ConfigNode* node = Find(key);
    Nested(node ? *node : Nothing(), Path(key.name), value);
  }
  template <class T>
  void operator()(FieldKey key, std::optional<T>& value) {
    const ConfigNode* node = Find(key);
    if (!node) return;
    if (node->kind == ConfigNode::Kind::kNothing) return value.reset();
    if (!value) value.emplace();
    Nested(*node, Path(key.name), *value);
  }
  template <class T>
  void operator()(FieldKey key, std::vector<T>& value) {
    const ConfigNode* node = Find(key);
    if (!node || !Holds(*node, ConfigNode::Kind::kList, key)) return;
    value.clear();
    for (const auto& [index, member] : node->members) {
      Nested(member, Path(key.name) + '.' + index, value.emplace_back());
    }
  }
  template <class T>
  void operator()(FieldKey key, std::map<std::string, T>& value) {
    const ConfigNode* node = Find(key);
    if (!node || !Holds(*node, ConfigNode::Kind::kMap, key)) return;
    value.clear();
    RefuseRepeated(*node, Path(key.name));
    for (const auto& [name, member] : node->members) Nested(member, Path(key.name) + '.' + name, value[name]);
  }

  // After all fields: refuses the keys that none of them has.
  void Finish() const;

 private:
  template <class T>
  void Nested(const ConfigNode& node, const std::string& path, T& value) {
    FieldReader reader(node, path, mistakes_);
    Fields(reader, value);
    reader.Finish();
  }
  const ConfigNode* Find(FieldKey key);  // null when not given
  ConfigNode Nothing() const;
  std::string Path(std::string_view key) const;
  bool Holds(const ConfigNode& node, ConfigNode::Kind kind, FieldKey key) const;
  void Wrong(const ConfigNode& node, std::string_view key, std::string_view what) const;
  bool Number(const ConfigNode& node, std::string_view key, double low, double high, double& value) const;
  void Numbers(FieldKey key, double* values, int size, double low, double high);
  void RefuseRepeated(const ConfigNode& node, const std::string& path) const;

  const ConfigNode& node_;
  std::string path_;
  Mistakes& mistakes_;
  std::vector<std::string> keys_, former_keys_;
};

// The visitor that writes a struct as YAML. Numbers read back to the same bits.
class FieldWriter {
 public:
  explicit FieldWriter(int indent = 0) : indent_(indent) {}

  void operator()(FieldKey key, double& value, double, double);
  void operator()(FieldKey key, std::optional<double>& value, double, double);
  void operator()(FieldKey key, int& value, int, int);
  void operator()(FieldKey key, std::uint64_t& value);
  void operator()(FieldKey key, bool& value);
  void operator()(FieldKey key, std::string& value);
  void operator()(FieldKey key, std::string& value, std::initializer_list<const char*>) {
    (*this)(key, value);
  }
  void operator()(FieldKey key, std::string& value, const std::vector<std::string>&) { (*this)(key, value); }
  template <int size>
  void operator()(FieldKey key, Eigen::Matrix<double, size, 1>& value, double, double) {
    Numbers(key.name, value.data(), size);
  }
  template <class T>
  void operator()(FieldKey key, T& value) {
    Block(key.name, Nested(value, indent_ + 1), "{}");
  }
  template <class T>
  void operator()(FieldKey key, std::optional<T>& value) {
    if (value)
      (*this)(key, *value);
    else
      Line(key.name, "null");
  }
  template <class T>
  void operator()(FieldKey key, std::vector<T>& value) {
    std::string all;
    for (T& each : value) all += AsListItem(Nested(each, indent_ + 2));
    Block(key.name, all, "[]");
  }
  template <class T>
  void operator()(FieldKey key, std::map<std::string, T>& value) {
    FieldWriter members(indent_ + 1);
    for (auto& [name, each] : value) members.Block(name, members.Nested(each, indent_ + 2), "{}");
    Block(key.name, members.text_, "{}");
  }

  const std::string& text() const { return text_; }

 private:
  template <class T>
  static std::string Nested(T& value, int indent) {
    FieldWriter writer(indent);
    Fields(writer, value);
    return writer.text_;
  }
  std::string AsListItem(std::string block) const;
  void Line(std::string_view key, std::string_view value);
  void Block(std::string_view key, const std::string& block, const char* empty);
  void Numbers(std::string_view key, const double* values, int size);

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
