// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

// Files that a user names. Such a name may be one of anything: of a device or a pipe that never ends or never
// answers, of a file larger than the memory, of nothing. What is read is a regular file of a bounded size.
namespace kestrel {

// How large the files may be that are read as a whole: of settings, and of what programs write (images,
// meshes, tables).
constexpr std::size_t kMaxTextBytes = 1u << 20;
constexpr std::size_t kMaxDataBytes = 1u << 28;

// Whether a name is one of a regular file, by links too. Never throws.
bool IsFile(const std::filesystem::path& file);

// What to say of a name that is none of a regular file: "there is no file 'x'", "'x' is a folder, not a
// file", "'x' cannot be read: File name too long".
std::string NoSuchFile(const std::filesystem::path& file);

struct FileContent {
  std::string bytes;
  std::string error;  // why there are none: "is a folder, not a file", "cannot be read: ..."; empty: all are
};

// All that is in a file of no more than so many bytes; one that is not regular or larger is not read. Never
// throws, never waits.
FileContent ReadUserFile(const std::filesystem::path& file, std::size_t max_bytes);

}  // namespace kestrel
