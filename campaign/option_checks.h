// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdlib>
#include <string>

// What CLI11's own checks let pass on the command line; a text says what is wrong.
namespace kestrel {

// An option that is given and empty would be as if it were not.
inline std::string NotEmpty(const std::string& text) { return text.empty() ? "it is empty" : ""; }

// nan is neither below nor above a range.
inline std::string NotNan(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? '\'' + text + "' is not a number" : "";
}

}  // namespace kestrel
