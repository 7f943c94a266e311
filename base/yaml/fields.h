// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// A parameter struct says once, beside its definition, what it holds:
//
//   template <class Visitor> void Fields(Visitor& v, WindParameters& p) {
//     v("mean_m_s", p.mean_m_s, 0.0, 20.0);                // double or int with its inclusive valid range
//     v("turbulence", p.turbulence);                       // bool
//     v("backend", p.backend, {"auto", "osmesa", "egl"});  // text from a list
//     v(Required("name"), p.name);                         // any text; the key must be given
//     v("gusts", p.gusts);                                 // a struct that has Fields
//     v(Renamed("min_value", "least_value"), p.min_value, 0.0, 1.0);  // a file may have its old name
//   }
//
// Readers and writers are visitors of it, so neither is known here.
struct FieldKey {
  // NOLINTNEXTLINE(google-explicit-constructor): a key is written as its name
  FieldKey(const char* key, bool must = false, const char* old = nullptr)
      : name(key), required(must), former(old) {}
  const char* name;
  bool required;
  const char* former;  // what the key was called in earlier versions; null: it always had its name
};
inline FieldKey Required(const char* key) { return {key, true}; }
inline FieldKey Renamed(const char* key, const char* former) { return {key, false, former}; }

}  // namespace kestrel
