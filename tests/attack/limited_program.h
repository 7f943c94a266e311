// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/content.h"

namespace kestrel {

// What a program took that was given little.
struct Taken {
  int status = -1;  // of the exit; -1: by a signal, that of the limits among them
  double cpu_s = 0, peak_mib = 0;
  std::string output;  // of both outputs
};

// Runs a program in a folder, with no input, which an attack may take down with it: it is ended after 30 s of
// the processor or a minute, or at 4 GiB.
inline Taken RunLimited(const std::filesystem::path& folder, std::vector<std::string> command,
                        const std::vector<std::string>& environment = {}) {
  const std::filesystem::path output = folder / "said.txt";
  const pid_t child = fork();
  if (child == 0) {
    const rlimit memory{std::uint64_t{4} << 30, std::uint64_t{4} << 30}, processor{30, 30};
    setrlimit(RLIMIT_AS, &memory);
    setrlimit(RLIMIT_CPU, &processor);
    std::vector<char*> arguments;
    for (std::string& each : command) arguments.push_back(each.data());
    arguments.push_back(nullptr);
    for (const std::string& each : environment) {
      const std::size_t equals = each.find('=');
      setenv(each.substr(0, equals).c_str(), each.substr(equals + 1).c_str(), 1);
    }
    if (chdir(folder.c_str()) != 0 || !std::freopen("/dev/null", "r", stdin) ||
        !std::freopen(output.c_str(), "w", stdout))
      _exit(126);
    dup2(STDOUT_FILENO, STDERR_FILENO);
    alarm(60);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  Taken taken;
  int status = 0;
  rusage used{};
  if (child < 0 || wait4(child, &status, 0, &used) != child) return taken;
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  taken.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  taken.cpu_s = seconds(used.ru_utime) + seconds(used.ru_stime);
  taken.peak_mib = static_cast<double>(used.ru_maxrss) / 1024;
  taken.output = Content(output);
  return taken;
}

}  // namespace kestrel
