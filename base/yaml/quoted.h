// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel {

// A text between double quotes, as YAML and JSON both read it.
std::string Quoted(const std::string& text);

}  // namespace kestrel
