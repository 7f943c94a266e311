// SPDX-License-Identifier: Apache-2.0
#include "base/user_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace kestrel {
namespace {

std::string Unreadable(int reason) { return fmt::format("cannot be read: {}", std::strerror(reason)); }

// What keeps a file from being read, by what the system says of it; empty: nothing.
std::string ErrorOf(const struct stat& is) {
  if (S_ISDIR(is.st_mode)) return "is a folder, not a file";
  if (!S_ISREG(is.st_mode)) return "is a device or a pipe, not a file";
  return {};
}

// Opened so that neither a pipe without a writer nor a file of /proc without news makes it wait.
class Opened {
 public:
  explicit Opened(const std::filesystem::path& file)
      : descriptor_(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  ~Opened() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

bool IsFile(const std::filesystem::path& file) {
  struct stat is {};
  return stat(file.c_str(), &is) == 0 && S_ISREG(is.st_mode);
}

std::string NoSuchFile(const std::filesystem::path& file) {
  struct stat is {};
  if (stat(file.c_str(), &is) == 0) return fmt::format("'{}' {}", file.string(), ErrorOf(is));
  if (errno == ENOENT || errno == ENOTDIR) return fmt::format("there is no file '{}'", file.string());
  return fmt::format("'{}' {}", file.string(), Unreadable(errno));
}

FileContent ReadUserFile(const std::filesystem::path& file, std::size_t max_bytes) {
  // A device may do something on being opened, so it is asked before; and what is open then is asked again.
  struct stat is {};
  if (stat(file.c_str(), &is) != 0) return {{}, Unreadable(errno)};
  if (std::string error = ErrorOf(is); !error.empty()) return {{}, std::move(error)};
  const Opened opened(file);
  if (opened.descriptor() < 0 || fstat(opened.descriptor(), &is) != 0) return {{}, Unreadable(errno)};
  if (std::string error = ErrorOf(is); !error.empty()) return {{}, std::move(error)};
  const auto size = static_cast<std::size_t>(is.st_size);
  FileContent content;
  if (size <= max_bytes) content.bytes.resize(size + 1);
  // To its end, wherever that is: a file of /proc holds more than the nothing that it says.
  for (std::size_t has = 0; size <= max_bytes && has <= max_bytes;) {
    constexpr std::size_t kPiece = 1u << 16;
    if (has == content.bytes.size()) content.bytes.resize(has + kPiece);
    const ssize_t got = read(opened.descriptor(), content.bytes.data() + has, content.bytes.size() - has);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return {{}, Unreadable(errno)};
    has += static_cast<std::size_t>(got);
    if (got > 0) continue;
    content.bytes.resize(has);
    return content;
  }
  return {{}, fmt::format("is too large; valid: up to {} bytes", max_bytes)};
}

}  // namespace kestrel
