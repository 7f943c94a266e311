// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kestrel {

// Another program that eats what is written to it, gives what is read from it, or answers, started without a shell.
// It does not hear the terminal's interrupt, so that it can finish its file when the run is broken off.
// Throws std::runtime_error: the program is missing, or it failed, with the last line that it said.
class PipedProcess {
 public:
  enum class Direction { kWrite, kRead, kBoth };
  explicit PipedProcess(std::vector<std::string> command, Direction does = Direction::kWrite);
  ~PipedProcess();
  PipedProcess(const PipedProcess&) = delete;
  PipedProcess& operator=(const PipedProcess&) = delete;

  void Write(std::string_view bytes);
  std::size_t Read(char* bytes, std::size_t most);  // less than most: its output has ended
  // Of a program that answers: the next line, without its end. None: its output has ended, the line is longer than
  // most, or it did not come within the patience.
  std::optional<std::string> ReadLine(std::size_t most, double patience_s);
  void Close();  // the end of the pipe; waits for the program
  void Kill();   // of the program, whatever it is at

 private:
  void Wait();
  [[noreturn]] void Fail();

  std::string name_;
  pid_t child_ = -1;
  int pipe_ = -1, errors_ = -1, status_ = 0;
  bool failed_ = false;
};

}  // namespace kestrel
