// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include <stdexcept>

namespace kestrel::sim {

// A function of a library that was opened at run time. Throws std::runtime_error where it has none of that name.
template <class Function>
Function Find(void* library, const char* name) {
  void* const symbol = dlsym(library, name);
  if (symbol == nullptr) throw std::runtime_error(fmt::format("the library has no {}", name));
  return reinterpret_cast<Function>(symbol);
}

}  // namespace kestrel::sim
