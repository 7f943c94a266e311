// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace kestrel {

// A parameter struct says once, beside its definition, what it holds:
//
//   inline void Fields(FieldVisitor& v, WindParameters& p) {
//     v("mean_m_s", p.mean_m_s, 0.0, 20.0);                // double or int with its inclusive valid range
//     v("direction", p.direction, -1.0, 1.0);              // a vector with the range of its elements
//     v("turbulence", p.turbulence);                       // bool
//     v("backend", p.backend, {"auto", "osmesa", "egl"});  // text from a list
//     v(Required("name"), p.name);                         // any text; the key must be given
//     v("gusts", p.gusts);                                 // a struct that has Fields
//     v(Renamed("min_value", "least_value"), p.min_value, 0.0, 1.0);  // a file may have its old name
//     v({"from_deg", "where it comes from, from north over east"}, p.from_deg, -360.0, 360.0);  // with its meaning
//   }
//
// Readers and writers are visitors of it, so neither is known here. A struct may be in std::optional, in
// std::vector, or in std::map by free names.

struct FieldKey {
  // NOLINTNEXTLINE(google-explicit-constructor): a key is written as its name
  FieldKey(const char* key, const char* of_it = nullptr) : name(key), meaning(of_it) {}
  const char* name;
  const char* meaning;  // to whoever writes a file: a phrase without a full stop; null: none is given
  bool required = false;
  const char* former = nullptr;  // what the key was called in earlier versions
};
inline FieldKey Required(const char* name, const char* meaning = nullptr) {
  FieldKey key(name, meaning);
  key.required = true;
  return key;
}
inline FieldKey Renamed(const char* name, const char* former, const char* meaning = nullptr) {
  FieldKey key(name, meaning);
  key.former = former;
  return key;
}

struct ConfigNode;
class FieldVisitor;

// A field: where its value lies and what it may be. Ranges are inclusive.
struct NumberField {
  double* value;
  double low, high;
};
struct OptionalNumberField {
  std::optional<double>* value;
  double low, high;
};
struct IntegerField {
  int* value;
  int low, high;
};
struct SeedField {
  std::uint64_t* value;
};
struct FlagField {
  bool* value;
};
struct TextField {
  std::string* value;
  std::optional<std::vector<std::string>> valid;  // none: any
};
struct TextsField {
  std::vector<std::string>* value;
};
struct NumbersField {
  double* values;
  int size;
  double low, high;
};
// What no struct describes, as it stands in the file.
struct NodeField {
  ConfigNode* value;
};
struct StructField {
  void Visit(FieldVisitor& visitor) const { fields(visitor, value); }
  void* value;
  void (*fields)(FieldVisitor&, void*);
};
// Any number of structs of one kind: one that may be absent, a list, or a map by names.
struct StructsField {
  enum class Kind { kOptional, kList, kMap };
  Kind kind;
  void* value;
  // Their names, of a map alone, and they. Valid until one is added.
  std::vector<std::pair<std::string, StructField>> (*all)(void*);
  StructField (*add)(void*, const std::string& name);
  void (*clear)(void*);
};
using FieldValue = std::variant<NumberField, OptionalNumberField, IntegerField, SeedField, FlagField,
                                TextField, TextsField, NumbersField, NodeField, StructField, StructsField>;

class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;
  virtual void Visit(const FieldKey& key, const FieldValue& field) = 0;

  void operator()(FieldKey key, double& value, double low, double high) {
    Visit(key, NumberField{&value, low, high});
  }
  void operator()(FieldKey key, std::optional<double>& value, double low, double high) {
    Visit(key, OptionalNumberField{&value, low, high});
  }
  void operator()(FieldKey key, int& value, int low, int high) {
    Visit(key, IntegerField{&value, low, high});
  }
  void operator()(FieldKey key, std::uint64_t& value) { Visit(key, SeedField{&value}); }
  void operator()(FieldKey key, bool& value) { Visit(key, FlagField{&value}); }
  void operator()(FieldKey key, std::string& value) { Visit(key, TextField{&value, std::nullopt}); }
  void operator()(FieldKey key, std::string& value, std::vector<std::string> valid) {
    Visit(key, TextField{&value, std::move(valid)});
  }
  void operator()(FieldKey key, std::string& value, std::initializer_list<const char*> valid) {
    Visit(key, TextField{&value, std::vector<std::string>(valid.begin(), valid.end())});
  }
  void operator()(FieldKey key, std::vector<std::string>& value) { Visit(key, TextsField{&value}); }
  void operator()(FieldKey key, ConfigNode& value) { Visit(key, NodeField{&value}); }
  template <class Vector>  // of Eigen, of a fixed size
  void operator()(FieldKey key, Vector& value, double low, double high) {
    static_assert(Vector::SizeAtCompileTime > 0);
    Visit(key, NumbersField{value.data(), Vector::SizeAtCompileTime, low, high});
  }
  template <class T>
  void operator()(FieldKey key, T& value) {
    Visit(key, Struct(value));
  }
  template <class T>
  void operator()(FieldKey key, std::optional<T>& value) {
    using Of = std::optional<T>;
    Visit(key,
          StructsField{StructsField::Kind::kOptional, &value,
                       [](void* of) {
                         std::vector<std::pair<std::string, StructField>> all;
                         if (auto& one = *static_cast<Of*>(of)) all.emplace_back("", Struct(*one));
                         return all;
                       },
                       [](void* of, const std::string&) { return Struct(static_cast<Of*>(of)->emplace()); },
                       [](void* of) { static_cast<Of*>(of)->reset(); }});
  }
  template <class T>
  void operator()(FieldKey key, std::vector<T>& value) {
    using Of = std::vector<T>;
    Visit(key, StructsField{
                   StructsField::Kind::kList, &value,
                   [](void* of) {
                     std::vector<std::pair<std::string, StructField>> all;
                     for (T& each : *static_cast<Of*>(of)) all.emplace_back("", Struct(each));
                     return all;
                   },
                   [](void* of, const std::string&) { return Struct(static_cast<Of*>(of)->emplace_back()); },
                   [](void* of) { static_cast<Of*>(of)->clear(); }});
  }
  template <class T>
  void operator()(FieldKey key, std::map<std::string, T>& value) {
    using Of = std::map<std::string, T>;
    Visit(key, StructsField{
                   StructsField::Kind::kMap, &value,
                   [](void* of) {
                     std::vector<std::pair<std::string, StructField>> all;
                     for (auto& [name, each] : *static_cast<Of*>(of)) all.emplace_back(name, Struct(each));
                     return all;
                   },
                   [](void* of, const std::string& name) { return Struct((*static_cast<Of*>(of))[name]); },
                   [](void* of) { static_cast<Of*>(of)->clear(); }});
  }

 private:
  template <class T>
  static StructField Struct(T& value) {
    return {&value, [](FieldVisitor& visitor, void* of) { Fields(visitor, *static_cast<T*>(of)); }};
  }
};

}  // namespace kestrel
