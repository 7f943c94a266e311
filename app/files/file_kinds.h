// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/yaml/describe_fields.h"

namespace kestrel::app {

// A kind of YAML file that a user writes, with all its keys. Where what it may hold depends on one of them, such as a
// scenario's on its mission, it has a variant for each value of that one.
struct FileKind {
  struct Variant {
    std::string name;  // the value of the selector
    std::vector<FieldDescription> fields;
  };
  std::string name;  // "scenario"
  std::string summary;
  std::string selector;  // the key that says which variant; empty: there is one variant, without a name
  std::vector<Variant> variants = {};                // one at least
  std::map<std::string, std::string> examples = {};  // what stands in a new file for a required key, as YAML
};

const std::vector<FileKind>& FileKinds();  // with what plug-ins add that were loaded before
std::vector<std::string> FileKindNames();  // known before any plug-in is loaded
const FileKind& FileKindNamed(const std::string& name);

// The keys that all variants have alike, in their order.
std::vector<FieldDescription> CommonFields(const FileKind& kind);
// The others of one.
std::vector<FieldDescription> OwnFields(const FileKind& kind, const FileKind::Variant& variant);

}  // namespace kestrel::app
