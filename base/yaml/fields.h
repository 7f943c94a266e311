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
//   }
//
// Readers and writers are visitors of it, so neither is known here.
struct FieldKey {
  // NOLINTNEXTLINE(google-explicit-constructor): a key is written as its name
  FieldKey(const char* key, bool must = false) : name(key), required(must) {}
  const char* name;
  bool required;
};
inline FieldKey Required(const char* key) { return {key, true}; }

}  // namespace kestrel
