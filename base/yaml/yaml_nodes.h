// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "base/yaml/config.h"

namespace kestrel {

// The values of a YAML text, aliases put in; nothing of an empty one. Throws YAML::Exception with the place:
// what is no YAML, more than one document, keys that are no names, and what would take much memory, as a few
// lines of aliases of aliases do. where_of: what a value's `where` says of a line, counted from 0.
ConfigNode ReadNodes(const std::string& text, const std::function<Place(int line)>& where_of);

// A value in one line, as JSON, which is YAML too: numbers, true and false as they stand, other texts in quotes.
std::string FlowText(const ConfigNode& node);

}  // namespace kestrel
