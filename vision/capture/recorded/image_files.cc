// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/image_files.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "vision/image_file.h"

namespace kestrel::vision {
namespace {

// Whether a name is the pattern's: itself, or with digits where the pattern has its "%d" or "%04d".
bool Matches(std::string_view name, std::string_view pattern) {
  const std::size_t from = pattern.find('%'), to = pattern.find('d', from);
  if (from == std::string_view::npos || to == std::string_view::npos) return name == pattern;
  const auto digits = [](std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
  };
  const std::string_view before = pattern.substr(0, from), after = pattern.substr(to + 1);
  return digits(pattern.substr(from + 1, to - from - 1)) && name.size() > before.size() + after.size() &&
         name.starts_with(before) && name.ends_with(after) &&
         digits(name.substr(before.size(), name.size() - before.size() - after.size()));
}

void SortByNumbers(std::vector<std::filesystem::path>& files) {
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return strverscmp(a.c_str(), b.c_str()) < 0; });
}

}  // namespace

std::vector<std::filesystem::path> ImageFilesOf(const std::filesystem::path& images) {
  std::vector<std::filesystem::path> files;
  std::error_code failed;
  const bool folder = std::filesystem::is_directory(images, failed);
  const std::filesystem::path in = folder ? images : images.parent_path();
  const std::string pattern = images.filename();
  for (std::filesystem::directory_iterator each(in.empty() ? "." : in, failed), end; !failed && each != end;
       each.increment(failed)) {
    const bool wanted = folder || Matches(each->path().filename().string(), pattern);
    if (wanted && (IsNamedAsImage(each->path()) || LooksLikeImage(each->path())))
      files.push_back(each->path());
  }
  SortByNumbers(files);
  return files;
}

std::vector<std::filesystem::path> FoldersIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> folders;
  std::error_code failed, none;
  for (std::filesystem::directory_iterator each(folder, failed), end; !failed && each != end;
       each.increment(failed))
    if (std::filesystem::is_directory(each->path(), none)) folders.push_back(each->path());
  SortByNumbers(folders);
  return folders;
}

}  // namespace kestrel::vision
