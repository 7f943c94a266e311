// SPDX-License-Identifier: Apache-2.0
#include "vision/folder_source.h"

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <vector>

#include "config/stopwatch.h"
#include "vision/live_camera.h"
#include "vision/pace.h"

namespace kestrel {
namespace {

class Source final : public ImageSource {
 public:
  explicit Source(const FolderSourceOptions& options) : options_(options), pace_(options.rate_hz) {}

  bool Open() override {
    std::error_code error;
    for (std::filesystem::directory_iterator each(options_.folder, error), end; !error && each != end;
         each.increment(error))
      if (each->is_regular_file() && cv::haveImageReader(each->path())) images_.push_back(each->path());
    std::sort(images_.begin(), images_.end(), [](const std::string& a, const std::string& b) {
      return strverscmp(a.c_str(), b.c_str()) < 0;
    });
    if (images_.empty()) trouble_ = "no images in " + options_.folder.string();
    return !images_.empty();
  }

  std::optional<Grabbed> Grab() override {
    if (next_ == images_.size()) return std::nullopt;
    pace_.Wait();
    const std::string& file = images_[next_++];
    Grabbed grabbed{cv::imread(file, options_.colour ? cv::IMREAD_COLOR : cv::IMREAD_GRAYSCALE),
                    MonotonicNow_s(), static_cast<std::int64_t>(next_)};
    if (grabbed.image.empty() || (!options_.size.empty() && grabbed.image.size() != options_.size)) {
      trouble_ = file + (grabbed.image.empty() ? " cannot be read" : " is of another size");
      return std::nullopt;
    }
    return grabbed;
  }

  bool Ended() const override { return true; }
  std::string Trouble() const override { return trouble_; }

 private:
  FolderSourceOptions options_;
  Pace pace_;
  std::vector<std::string> images_;
  std::size_t next_ = 0;
  std::string trouble_;
};

}  // namespace

ImageSourceMaker FolderSource(const FolderSourceOptions& options) {
  return [options] { return std::make_unique<Source>(options); };
}

}  // namespace kestrel
