// SPDX-License-Identifier: Apache-2.0
#include "base/file/writer_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "base/diagnostics.h"

namespace kestrel {

namespace fs = std::filesystem;

WriterLock::WriterLock(const fs::path& file, const std::string& refused)
    : descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0)
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), std::strerror(errno)));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError({}, refused);
}

WriterLock::~WriterLock() { close(descriptor_); }

WriterLock LockFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", folder.string(), error.message()));
  return WriterLock(folder / ".lock",
                    fmt::format("--out: another process is writing to '{}'; valid: to let it end, or another "
                                "folder",
                                folder.string()));
}

}  // namespace kestrel
