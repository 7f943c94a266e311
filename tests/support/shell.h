// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/content.h"

namespace kestrel {

struct Ended {
  int status;  // of the exit; -1: by a signal
  std::string out, err;
};

// Runs a shell's command in a folder.
inline Ended Shell(const std::filesystem::path& folder, const std::string& command) {
  const int status = std::system(
      fmt::format("cd {0} && ( {1} ) >{0}/out.txt 2>{0}/err.txt", folder.string(), command).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Content(folder / "out.txt"),
          Content(folder / "err.txt")};
}

}  // namespace kestrel
