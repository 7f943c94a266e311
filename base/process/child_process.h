// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kestrel {

// Another program beside this one, started without a shell; what it says goes to a file. It does not hear the
// terminal's interrupt. Ended by force with this object.
class ChildProcess {
 public:
  // environment: "NAME=value", beside this program's own. Throws std::runtime_error: it cannot be started.
  ChildProcess(std::vector<std::string> command, const std::vector<std::string>& environment,
               std::filesystem::path says);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void Signal(int signal);
  // Its exit status, 128 + the signal that ended it; none: it runs.
  std::optional<int> Ended();
  std::optional<int> Wait(double max_s);
  std::string Output() const;  // until now

 private:
  std::filesystem::path says_;
  pid_t child_ = -1;
  std::optional<int> status_;
};

}  // namespace kestrel
