// SPDX-License-Identifier: Apache-2.0
#include "base/process/own_program.h"

#include <sys/auxv.h>

#include <system_error>

namespace kestrel {

namespace fs = std::filesystem;

fs::path OwnProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) return program;
  const auto* const name = reinterpret_cast<const char*>(getauxval(AT_EXECFN));
  return name ? fs::absolute(name, error) : fs::path();
}

}  // namespace kestrel
