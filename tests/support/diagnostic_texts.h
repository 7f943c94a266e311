// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/diagnostics.h"

namespace kestrel {

// What is printed of each mistake of an error.
inline std::vector<std::string> Texts(const InputError& error) {
  std::vector<std::string> texts;
  for (const Diagnostic& each : error.diagnostics) texts.push_back(each.Text());
  return texts;
}

}  // namespace kestrel
