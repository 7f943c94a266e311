// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace kestrel {

// The name that a file has until it is complete: "telemetry.csv.part".
std::filesystem::path PartOf(const std::filesystem::path& file);

// Gives a file that was written as PartOf its final name, replacing what had it.
void Complete(const std::filesystem::path& file);

// Writes a whole file, under its final name only once it is complete. Throws std::runtime_error with the file
// and the reason.
void WriteFile(const std::filesystem::path& file, std::string_view content);

// A file that is written piece by piece as PartOf its name. Every write is checked: std::runtime_error with
// the file and the reason. Without Close, or after a failure, what was written stays under the name of the
// part.
class PartFile {
 public:
  explicit PartFile(std::filesystem::path file);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  void Write(std::string_view content);
  void Close();  // gives the file its final name

 private:
  [[noreturn]] void Fail(int reason);

  std::filesystem::path file_;
  std::FILE* stream_ = nullptr;
};

}  // namespace kestrel
