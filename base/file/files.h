// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "base/diagnostics.h"

namespace kestrel {

class Mistakes;

// The name that a file has until it is complete: "telemetry.csv.part".
std::filesystem::path PartOf(const std::filesystem::path& file);

// Gives a file that was written as PartOf its final name, replacing what had it.
void Complete(const std::filesystem::path& file);

// Writes a whole file, under its final name only once it is complete. Throws std::runtime_error with the file
// and the reason.
void WriteFile(const std::filesystem::path& file, std::string_view content);

// All that is in a file (base/user_file.h); nothing of one that cannot be read.
std::string ReadFile(const std::filesystem::path& file);

// Whether a run or a campaign may be called so, as its folder is: no slash, no leading dot, no control
// character.
bool NamesFolder(std::string_view name);

// Before the work whose fruit is to be written there: what could not be is a mistake of that option. Nothing
// is left behind, and nothing there is touched. An empty name asks for nothing.
void CheckWritableFile(const std::filesystem::path& file, const char* option, Mistakes& mistakes);
void CheckWritableFolder(const std::filesystem::path& folder, const char* option, Mistakes& mistakes);

// Whether two names are of one file, be it there or not; by links too.
bool SameFile(const std::filesystem::path& a, const std::filesystem::path& b);

// Whether a name ends in one of these, whatever its case.
bool HasEnding(const std::filesystem::path& file, std::initializer_list<const char*> endings);

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
  void Flush();  // to the system, which keeps it if the program dies
  void Close();  // gives the file its final name

 private:
  [[noreturn]] void Fail(int reason);

  std::filesystem::path file_;
  std::FILE* stream_ = nullptr;
};

}  // namespace kestrel
