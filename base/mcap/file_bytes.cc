// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/diagnostics.h"
#include "base/mcap/wire.h"
#include "base/user_file.h"

namespace kestrel::mcap {

FileBytes::FileBytes(const std::filesystem::path& file) : name_(file) {
  if (!IsFile(file)) throw InputError(file.string(), NoSuchFile(file));
  file_ = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat is {};
  if (file_ < 0 || fstat(file_, &is) != 0)
    throw InputError(file.string(), fmt::format("cannot be read: {}", std::strerror(errno)));
  size_ = static_cast<std::uint64_t>(is.st_size);
}

FileBytes::~FileBytes() {
  if (file_ >= 0) close(file_);
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : name_(std::move(other.name_)), file_(std::exchange(other.file_, -1)), size_(other.size_) {}

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(file_, other.file_);
  std::swap(size_, other.size_);
  return *this;
}

std::string FileBytes::At(std::uint64_t offset, std::uint64_t count) const {
  if (offset > size_ || count > size_ - offset)
    throw Malformed(fmt::format("{} bytes from {} on, where the file has {}", count, offset, size_));
  std::string bytes(count, '\0');
  for (std::size_t filled = 0; filled < count;) {
    const ssize_t got = pread(file_, &bytes[filled], count - filled, static_cast<off_t>(offset + filled));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw Malformed(
          fmt::format("cannot be read: {}", got < 0 ? std::strerror(errno) : "it became shorter"));
    filled += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace kestrel::mcap
