// SPDX-License-Identifier: Apache-2.0
#include "scenarios/this_program.h"

#include <sys/auxv.h>

#include <system_error>

namespace kestrel {
namespace {

// As it was started, before anything may have gone to another folder.
std::filesystem::path AsStarted() {
  const auto* const name = reinterpret_cast<const char*>(getauxval(AT_EXECFN));
  std::error_code error;
  const auto file = std::filesystem::absolute(name ? name : "", error);
  return error ? std::filesystem::path() : file.lexically_normal();
}

const std::filesystem::path as_started = AsStarted();

}  // namespace

std::filesystem::path ThisProgram() {
  std::error_code error;
  const auto file = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? as_started : file;
}

}  // namespace kestrel
