// SPDX-License-Identifier: Apache-2.0
#include "scenarios/files.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace kestrel {

std::filesystem::path PartOf(const std::filesystem::path& file) { return file.string() + ".part"; }

void Complete(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(PartOf(file), file, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), error.message()));
}

void WriteFile(const std::filesystem::path& file, std::string_view content) {
  PartFile part(file);
  part.Write(content);
  part.Close();
}

PartFile::PartFile(std::filesystem::path file) : file_(std::move(file)) {
  stream_ = std::fopen(PartOf(file_).c_str(), "wbe");
  if (!stream_) Fail(errno);
}

PartFile::~PartFile() {
  if (stream_) std::fclose(stream_);
}

void PartFile::Write(std::string_view content) {
  if (!stream_) Fail(EBADF);
  if (std::fwrite(content.data(), 1, content.size(), stream_) != content.size()) Fail(errno);
}

void PartFile::Close() {
  if (!stream_) Fail(EBADF);  // an earlier write failed
  // A full disk may show only when the last bytes leave the buffer.
  if (std::fflush(stream_) != 0) Fail(errno);
  if (std::fclose(std::exchange(stream_, nullptr)) != 0) Fail(errno);
  Complete(file_);
}

void PartFile::Fail(int reason) {
  if (stream_) std::fclose(std::exchange(stream_, nullptr));
  throw std::runtime_error(fmt::format("cannot write {}: {}", file_.string(), std::strerror(reason)));
}

}  // namespace kestrel
