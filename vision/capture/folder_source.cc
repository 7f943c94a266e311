// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/folder_source.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/stopwatch.h"
#include "vision/capture/live_camera.h"
#include "vision/capture/pace.h"
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

class FolderReader final : public ImageSource {
 public:
  explicit FolderReader(const FolderSourceOptions& options)
      : options_(options), pace_(options.rate_hz), depth_(options.bits) {}

  bool Open() override {
    std::error_code failed;
    const bool folder = std::filesystem::is_directory(options_.images, failed);
    const std::filesystem::path in = folder ? options_.images : options_.images.parent_path();
    const std::string pattern = options_.images.filename();
    for (std::filesystem::directory_iterator each(in.empty() ? "." : in, failed), end; !failed && each != end;
         each.increment(failed)) {
      const bool wanted = folder || Matches(each->path().filename().string(), pattern);
      if (wanted && (IsNamedAsImage(each->path()) || LooksLikeImage(each->path())))
        images_.push_back(each->path());
    }
    std::sort(images_.begin(), images_.end(), [](const std::string& a, const std::string& b) {
      return strverscmp(a.c_str(), b.c_str()) < 0;
    });
    if (images_.empty()) error_ = "no images in " + options_.images.string();
    return !images_.empty();
  }

  std::optional<Grabbed> Grab() override {
    error_.clear();
    if (next_ == images_.size()) return std::nullopt;
    pace_.Wait();
    const std::string& file = images_[next_++];
    const ImageFile read = ReadImageFile(file, options_.colour ? ImageColours::kColour : ImageColours::kGrey);
    std::string wrong = read.pixels.empty() ? read.error : depth_.Include(read);
    if (wrong.empty() && !options_.size.empty() && read.pixels.size() != options_.size)
      wrong = "is of another size";
    if (wrong.empty() && depth_.guessed())
      wrong = "has pixels of 16 bits and does not say how many are used; valid: ?bits=N after the folder";
    if (!wrong.empty()) {
      error_ = file + ' ' + wrong;
      return std::nullopt;
    }
    Grabbed grabbed{depth_.EightBits(read), MonotonicNow_s(), static_cast<std::int64_t>(next_)};
    return grabbed;
  }

  bool Ended() const override { return true; }
  std::string Error() const override { return error_; }

 private:
  FolderSourceOptions options_;
  Pace pace_;
  PixelDepth depth_;
  std::vector<std::string> images_;
  std::size_t next_ = 0;
  std::string error_;
};

}  // namespace

ImageSourceMaker FolderSource(const FolderSourceOptions& options) {
  return [options] { return std::make_unique<FolderReader>(options); };
}

}  // namespace kestrel::vision
