// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kestrel {

// That one process alone writes somewhere: held until it is destroyed or the process ends, however it ends.
// It is of a file of its own, which stays. On a file system without locks it holds nobody off.
class WriterLock {
 public:
  // Throws InputError with the text refused: another has it; std::runtime_error: its file cannot be written.
  WriterLock(const std::filesystem::path& file, const std::string& refused);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int descriptor_ = -1;
};

// Of the records of a flight or of flights: makes the folder where there is none.
WriterLock LockFolder(const std::filesystem::path& folder);

}  // namespace kestrel
