// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/describe_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/yaml/yaml_fields.h"
#include "base/yaml/yaml_nodes.h"

namespace kestrel {
namespace {

// Those of both, in their order; one that is not alike in both may be anything.
void Unite(const std::vector<FieldDescription>& more, std::vector<FieldDescription>& all) {
  for (const FieldDescription& each : more) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const auto& other) { return other.key == each.key; });
    if (found == all.end())
      all.push_back(each);
    else if (found->kind != each.kind || found->size != each.size)
      found->kind = FieldKind::kAny;
  }
}

// Which keys a struct has may depend on what it is, as those of a fault on its type: those of all cases.
void VisitCases(const StructField& field, const std::vector<TextField>& selectors, std::size_t next,
                std::vector<FieldDescription>& all) {
  if (next == selectors.size()) {
    DescribingVisitor visitor;
    field.Visit(visitor);
    return Unite(visitor.fields, all);
  }
  const std::string own = *selectors[next].value;
  for (const std::string& each : *selectors[next].valid) {
    *selectors[next].value = each;
    VisitCases(field, selectors, next + 1, all);
  }
  *selectors[next].value = own;
}

std::vector<FieldDescription> FieldsOf(const StructField& field) {
  DescribingVisitor visitor;
  field.Visit(visitor);
  if (!visitor.selectors.empty()) VisitCases(field, visitor.selectors, 0, visitor.fields);
  return std::move(visitor.fields);
}

struct Describer {
  FieldDescription& of;

  void operator()(const NumberField& f) const { Number(FieldKind::kNumber, f.low, f.high); }
  void operator()(const OptionalNumberField& f) const {
    Number(FieldKind::kNumber, f.low, f.high);
    of.nullable = true;
  }
  void operator()(const IntegerField& f) const { Number(FieldKind::kInteger, f.low, f.high); }
  void operator()(const SeedField&) const { of.kind = FieldKind::kSeed; }
  void operator()(const FlagField&) const { of.kind = FieldKind::kFlag; }
  void operator()(const TextField& f) const {
    of.kind = FieldKind::kText;
    of.valid = f.valid.value_or(std::vector<std::string>{});
  }
  void operator()(const TextsField&) const { of.kind = FieldKind::kTexts; }
  void operator()(const NumbersField& f) const {
    Number(FieldKind::kNumbers, f.low, f.high);
    of.size = f.size;
  }
  void operator()(const NodeField&) const { of.kind = FieldKind::kAny; }
  void operator()(const StructField& f) const {
    of.kind = FieldKind::kStruct;
    of.fields = FieldsOf(f);
  }
  void operator()(const StructsField& f) const {
    using Several = StructsField::Kind;
    of.kind = f.kind == Several::kList  ? FieldKind::kList
              : f.kind == Several::kMap ? FieldKind::kMap
                                        : FieldKind::kStruct;
    of.nullable = f.kind == Several::kOptional;
    // The first of those that it has says how it is by default, or one that is added to a list of none.
    const auto all = f.all(f.value);
    of.fields = FieldsOf(all.empty() ? f.add(f.value, "NAME") : all.front().second);
    if (all.empty()) f.clear(f.value);
  }

  void Number(FieldKind kind, double low, double high) const {
    of.kind = kind;
    of.low = low;
    of.high = high;
  }
};

// What the writer writes of it on the key's own line.
std::string ValueText(const FieldKey& key, const FieldValue& field) {
  if (std::holds_alternative<NodeField>(field)) return "";
  FieldWriter writer;
  writer.Visit(key, field);
  const std::string& text = writer.text();
  const std::size_t end = text.find('\n');
  const std::size_t begin = std::string_view(key.name).size() + 2;  // "key: "
  if (end == std::string::npos || end + 1 != text.size() || end <= begin) return "";
  return text.substr(begin, end - begin);
}

// All of what the writer writes, in one line.
std::string FlowValue(const FieldKey& key, const FieldValue& field) {
  FieldWriter writer;
  writer.Visit(key, field);
  return FlowText(ReadNodes(writer.text(), [](int) { return Place(); }).members.front().node);
}

// Walks down a dotted path.
class PathVisitor final : public FieldVisitor {
 public:
  explicit PathVisitor(std::string_view path) : name_(path.substr(0, path.find('.'))) {
    if (name_.size() < path.size()) rest_ = path.substr(name_.size() + 1);
  }

  void Visit(const FieldKey& key, const FieldValue& field) override {
    if (name_ != key.name) return;
    if (rest_) return std::visit([&](const auto& of_kind) { Into(key, of_kind); }, field);
    DescribingVisitor visitor;
    visitor.Visit(key, field);
    found = std::move(visitor.fields.front());
    found->value = FlowValue(key, field);
  }

  std::optional<FieldDescription> found;

 private:
  void Below(const StructField& field, std::string_view path) {
    PathVisitor visitor(path);
    field.Visit(visitor);
    found = std::move(visitor.found);
  }

  void Into(const FieldKey&, const StructField& field) { Below(field, *rest_); }
  void Into(const FieldKey&, const StructsField& field) {
    const auto all = field.all(field.value);
    if (field.kind == StructsField::Kind::kOptional)
      return all.empty() ? void() : Below(all.front().second, *rest_);
    const std::string_view name = rest_->substr(0, rest_->find('.'));
    if (name.size() == rest_->size()) return;  // one as a whole
    for (std::size_t i = 0; i < all.size(); ++i)
      if (name == (field.kind == StructsField::Kind::kMap ? all[i].first : std::to_string(i)))
        return Below(all[i].second, rest_->substr(name.size() + 1));
  }
  void Into(const FieldKey& key, const NumbersField& field) {
    for (int i = 0; i < field.size; ++i) {
      if (*rest_ != std::to_string(i)) continue;
      DescribingVisitor visitor;
      visitor.Visit(key, NumberField{field.values + i, field.low, field.high});
      found = std::move(visitor.fields.front());
    }
  }
  template <class Field>
  void Into(const FieldKey&, const Field&) {}

  std::string_view name_;
  std::optional<std::string_view> rest_;  // none: the path ends here
};

std::string RangeText(const FieldDescription& f) {
  if (!f.low || !f.high || (*f.low <= -1e9 && *f.high >= 1e9)) return "";
  if (*f.high >= 1e9) return fmt::format(" from {:g}", *f.low);
  return fmt::format(" from {:g} to {:g}", *f.low, *f.high);
}

}  // namespace

void DescribingVisitor::Visit(const FieldKey& key, const FieldValue& field) {
  FieldDescription description;
  description.key = key.name;
  if (key.meaning) description.meaning = key.meaning;
  description.required = key.required;
  if (key.former) description.former = key.former;
  description.value = ValueText(key, field);
  std::visit(Describer{description}, field);
  if (const auto* text = std::get_if<TextField>(&field); text && text->valid && key.required)
    selectors.push_back(*text);
  fields.push_back(std::move(description));
}

std::optional<FieldDescription> DescribeAt(const std::function<void(FieldVisitor&)>& fields,
                                           std::string_view path) {
  PathVisitor visitor(path);
  fields(visitor);
  return std::move(visitor.found);
}

std::string TypeText(const FieldDescription& f) {
  const std::string none = f.nullable ? ", or null" : "";
  switch (f.kind) {
    case FieldKind::kNumber:
      return "number" + RangeText(f) + none;
    case FieldKind::kInteger:
      return "integer" + RangeText(f);
    case FieldKind::kSeed:
      return "integer from 0";
    case FieldKind::kFlag:
      return "true or false";
    case FieldKind::kText:
      return f.valid.empty() ? "text" : fmt::format("one of {}", fmt::join(f.valid, ", "));
    case FieldKind::kTexts:
      return "list of texts";
    case FieldKind::kNumbers:
      return fmt::format("list of {} numbers{}", f.size, RangeText(f));
    case FieldKind::kAny:
      return "as its meaning says";
    case FieldKind::kStruct:
      return "map" + none;
    case FieldKind::kList:
      return "list of maps";
    case FieldKind::kMap:
      return "map of maps by names";
  }
  return "";
}

}  // namespace kestrel
