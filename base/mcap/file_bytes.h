// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace kestrel::mcap {

// A file of any size, of which parts are read. Throws InputError where it cannot be opened: no regular file.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& file);
  ~FileBytes();
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&& other) noexcept;

  const std::filesystem::path& name() const { return name_; }
  std::uint64_t size() const { return size_; }
  // Throws Malformed where the file ends before, or cannot be read.
  std::string At(std::uint64_t offset, std::uint64_t count) const;

 private:
  std::filesystem::path name_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace kestrel::mcap
