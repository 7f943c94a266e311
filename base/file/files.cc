// SPDX-License-Identifier: Apache-2.0
#include "base/file/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/printable.h"
#include "base/user_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

// Why a file of that name could not be written; empty: it could.
std::string WhyNotWritten(const fs::path& file) {
  std::error_code none;
  if (fs::is_directory(file, none)) return "it is a folder";
  if (fs::exists(file, none) && !fs::is_regular_file(file, none))
    return "it is a device or a pipe, which a file would replace";
  if (file.has_parent_path() && !fs::is_directory(file.parent_path(), none))
    return fmt::format("there is no folder '{}'", file.parent_path().string());
  const fs::path part = PartOf(file);
  const bool existed = fs::exists(part, none);
  errno = 0;
  if (!std::ofstream(part, std::ios::app)) return std::strerror(errno ? errno : EIO);
  if (!existed) fs::remove(part, none);
  return {};
}

std::string NotAName(const fs::path& file) {
  return fmt::format("'{}' holds a control character; valid: a name without", file.string());
}

}  // namespace

std::filesystem::path PartOf(const std::filesystem::path& file) { return file.string() + ".part"; }

void Complete(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(PartOf(file), file, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), error.message()));
}

void WriteFile(const std::filesystem::path& file, std::string_view content) {
  PartFile part(file);
  try {
    part.Write(content);
    part.Close();
  } catch (const std::runtime_error&) {
    std::error_code none;
    fs::remove(PartOf(file), none);  // of no use: it is written at once or not
    throw;
  }
}

std::string ReadFile(const fs::path& file) { return ReadUserFile(file, kMaxDataBytes).bytes; }

bool NamesFolder(std::string_view name) {
  return name.find_first_of("/\\") == std::string_view::npos && !name.starts_with('.') && !HasControl(name);
}

void CheckWritableFile(const fs::path& file, const char* option, Mistakes& mistakes) {
  if (file.empty()) return;
  if (HasControl(file.native())) return mistakes.Add(option, "", NotAName(file));
  const std::string why = WhyNotWritten(file);
  if (!why.empty()) mistakes.Add(option, "", fmt::format("'{}' cannot be written: {}", file.string(), why));
}

void CheckWritableFolder(const fs::path& folder, const char* option, Mistakes& mistakes) {
  if (folder.empty()) return;
  if (HasControl(folder.native())) return mistakes.Add(option, "", NotAName(folder));
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    return mistakes.Add(option, "", fmt::format("'{}' is not a folder", folder.string()));
  std::vector<fs::path> missing;  // the innermost first
  // A link that leads nowhere is there, and stays.
  for (fs::path each = fs::absolute(folder).lexically_normal(); !fs::exists(fs::symlink_status(each, error));
       each = each.parent_path())
    missing.push_back(each);
  fs::create_directories(folder, error);
  const std::string why = error ? error.message() : WhyNotWritten(folder / "summary.json");
  for (const fs::path& each : missing) fs::remove(each, error);
  if (!why.empty()) mistakes.Add(option, "", fmt::format("'{}' cannot be written: {}", folder.string(), why));
}

bool SameFile(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

bool HasEnding(const fs::path& file, std::initializer_list<const char*> endings) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
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

void PartFile::Flush() {
  if (!stream_) Fail(EBADF);
  if (std::fflush(stream_) != 0) Fail(errno);
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
