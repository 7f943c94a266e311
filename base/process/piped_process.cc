// SPDX-License-Identifier: Apache-2.0
#include "base/process/piped_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "base/stopwatch.h"

extern char** environ;

namespace kestrel {
namespace {

std::string LastLine(int file) {
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = pread(file, buffer, sizeof buffer, static_cast<off_t>(text.size()))) > 0;)
    text.append(buffer, n);
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r^") != std::string::npos)
      last = line.substr(line.find_first_not_of(" \t"));
  }
  return last;
}

}  // namespace

PipedProcess::PipedProcess(std::vector<std::string> command, Direction does) : name_(command.at(0)) {
  // A socket rather than a pipe: a write to a program that has died is then an error, not a signal. And what
  // the program says goes to a file in memory, so that it can say much before anyone listens.
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw std::runtime_error(fmt::format("cannot start {}: {}", name_, std::strerror(errno)));
  }
  pipe_ = ends[0];
  errors_ = memfd_create("errors", MFD_CLOEXEC);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  const auto join = [&](int file, bool piped) {
    if (piped)
      posix_spawn_file_actions_adddup2(&files, ends[1], file);
    else
      posix_spawn_file_actions_addopen(&files, file, "/dev/null", O_RDWR, 0);
  };
  join(STDIN_FILENO, does != Direction::kRead);
  join(STDOUT_FILENO, does != Direction::kWrite);
  posix_spawn_file_actions_adddup2(&files, errors_, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  std::vector<char*> arguments;
  for (std::string& each : command) arguments.push_back(each.data());
  arguments.push_back(nullptr);
  const int error = posix_spawnp(&child_, name_.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  close(ends[1]);
  if (error == 0) return;
  close(pipe_), close(errors_);
  throw std::runtime_error(
      error == ENOENT
          ? fmt::format("the program {0} is not installed: install the package that has it", name_)
          : fmt::format("cannot start {}: {}", name_, std::strerror(error)));
}

PipedProcess::~PipedProcess() {
  Wait();
  close(errors_);
}

void PipedProcess::Write(std::string_view bytes) {
  if (child_ < 0) Fail();
  while (!bytes.empty()) {
    const ssize_t n = send(pipe_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) Wait(), Fail();
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

std::size_t PipedProcess::Read(char* bytes, std::size_t most) {
  if (child_ < 0) Fail();
  std::size_t got = 0;
  while (got < most) {
    const ssize_t n = recv(pipe_, bytes + got, most - got, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;  // why it ended is Close's to say
    got += static_cast<std::size_t>(n);
  }
  return got;
}

std::optional<std::string> PipedProcess::ReadLine(std::size_t most, double patience_s) {
  const double until_s = MonotonicNow_s() + patience_s;
  const auto comes = [&] {
    pollfd from{pipe_, POLLIN, 0};
    for (double left_s; (left_s = until_s - MonotonicNow_s()) > 0;) {
      const int n = poll(&from, 1, static_cast<int>(std::ceil(1e3 * left_s)));
      if (n > 0) return true;
      if (n < 0 && errno != EINTR) return false;
    }
    return false;
  };
  std::string line;
  for (char next; line.size() <= most && comes() && Read(&next, 1) == 1; line += next)
    if (next == '\n') return line;
  return {};
}

void PipedProcess::Close() {
  Wait();
  if (failed_ || status_ != 0) Fail();
}

void PipedProcess::Kill() {
  if (child_ > 0) kill(-child_, SIGKILL);  // it leads a group of its own
  Wait();
}

void PipedProcess::Wait() {
  if (child_ < 0) return;
  close(std::exchange(pipe_, -1));
  while (waitpid(child_, &status_, 0) < 0 && errno == EINTR) {}
  child_ = -1;
}

void PipedProcess::Fail() {
  failed_ = true;
  const std::string errors = LastLine(errors_);
  const std::string how = WIFSIGNALED(status_) ? fmt::format("was ended by signal {}", WTERMSIG(status_))
                                               : fmt::format("gave up with status {}", WEXITSTATUS(status_));
  throw std::runtime_error(fmt::format("{} {}{}{}", name_, how, errors.empty() ? "" : ": ", errors));
}

}  // namespace kestrel
