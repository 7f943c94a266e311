// SPDX-License-Identifier: Apache-2.0
#include "base/process/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "base/stopwatch.h"

extern char** environ;

namespace kestrel {

ChildProcess::ChildProcess(std::vector<std::string> command, const std::vector<std::string>& environment,
                           std::filesystem::path says)
    : says_(std::move(says)) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, says_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  std::vector<char*> arguments, variables;
  for (std::string& each : command) arguments.push_back(each.data());
  arguments.push_back(nullptr);
  std::vector<std::string> ours = environment;
  for (std::string& each : ours) variables.push_back(each.data());
  for (char** each = environ; *each; ++each) {
    const std::string_view name = std::string_view(*each).substr(0, std::string_view(*each).find('=') + 1);
    bool replaced = false;
    for (const std::string& one : environment) replaced = replaced || one.starts_with(name);
    if (!replaced) variables.push_back(*each);
  }
  variables.push_back(nullptr);
  const int error =
      posix_spawn(&child_, arguments.front(), &files, &attributes, arguments.data(), variables.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0)
    throw std::runtime_error(fmt::format("cannot start {}: {}", command.front(), std::strerror(error)));
}

ChildProcess::~ChildProcess() {
  if (Ended()) return;
  Signal(SIGKILL);
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {}
}

void ChildProcess::Signal(int signal) {
  if (!Ended()) kill(child_, signal);
}

std::optional<int> ChildProcess::Ended() {
  if (status_) return status_;
  int status = 0;
  if (waitpid(child_, &status, WNOHANG) == child_)
    status_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return status_;
}

std::optional<int> ChildProcess::Wait(double max_s) {
  const double until_s = MonotonicNow_s() + max_s;
  while (!Ended() && MonotonicNow_s() < until_s) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return status_;
}

std::string ChildProcess::Output() const {
  std::ifstream in(says_);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace kestrel
