// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel {

enum class FieldKind {
  kNumber,
  kInteger,
  kSeed,  // an integer from 0
  kFlag,
  kText,
  kTexts,
  kNumbers,
  kAny,  // what no struct describes, or has one kind in one case and another in another
  kStruct,
  kList,  // of structs
  kMap    // of structs, by names
};

// What one key of a file may hold, by the Fields of its struct: for texts that explain it.
struct FieldDescription {
  std::string key;
  std::string meaning;  // a phrase; empty: none is given
  FieldKind kind = FieldKind::kAny;
  bool required = false;
  bool nullable = false;    // it may be null: there is none
  std::string former = {};  // what the key was called in earlier versions
  std::string value = {};   // the default, as YAML has it; empty of structs that are not empty
  std::optional<double> low = {}, high = {};  // of numbers
  int size = 0;                               // of kNumbers
  std::vector<std::string> valid = {};        // of kText; none: any
  std::vector<FieldDescription> fields = {};  // of a struct, or of one that a list or a map holds
  bool operator==(const FieldDescription&) const = default;
};

class DescribingVisitor final : public FieldVisitor {
 public:
  void Visit(const FieldKey& key, const FieldValue& field) override;
  std::vector<FieldDescription> fields;  // in the order in which they were visited
  std::vector<TextField> selectors;      // of them, the texts from a list that must be given
};

// Of a struct whose values are the defaults.
template <class T>
std::vector<FieldDescription> Describe(T value) {
  DescribingVisitor visitor;
  Fields(visitor, value);
  return std::move(visitor.fields);
}

// The field at a dotted path, such as targets.0.velocity_m_s, of this very value; its `value` is in one line, as
// FlowText has it. None: there is no such field.
std::optional<FieldDescription> DescribeAt(const std::function<void(FieldVisitor&)>& fields,
                                           std::string_view path);

// "number from 0 to 20", "one of auto, osmesa, egl", "list of 3 numbers from 0 to 1".
std::string TypeText(const FieldDescription& field);

}  // namespace kestrel
