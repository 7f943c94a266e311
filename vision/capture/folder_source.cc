// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/folder_source.h"

#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "vision/capture/pace.h"
#include "vision/capture/recorded/recorded_images.h"
#include "vision/image_file.h"

namespace kestrel::vision {
namespace {

class FolderReader final : public ImageSource {
 public:
  explicit FolderReader(const FolderSourceOptions& options)
      : options_(options), pace_(options.rate_hz), depth_(options.bits) {}

  bool Open() override {
    images_ = options_.opened;
    if (!images_) {
      Mistakes mistakes;
      images_ = std::make_shared<const RecordedImages>(
          OpenRecordedImages(options_.images, options_.topic, mistakes));
      if (!mistakes.empty()) {
        error_ = InputError(mistakes.all()).what();
        return false;
      }
    }
    if (options_.as_recorded && !images_->stamped()) {
      error_ = options_.images.string() + " has no stamps to come by; valid: a rate";
      return false;
    }
    try {
      read_ = images_->reader();
    } catch (const std::runtime_error& e) {
      error_ = e.what();
      return false;
    }
    return true;
  }

  std::optional<Grabbed> Grab() override {
    error_.clear();
    if (next_ == images_->size()) return std::nullopt;
    const std::size_t i = next_++;
    std::optional<double> due_s;
    if (options_.as_recorded)
      due_s = WaitForStamp(i);
    else
      pace_.Wait();
    const ImageFile read = read_(i, options_.colour ? ImageColours::kColour : ImageColours::kGrey);
    std::string wrong = read.pixels.empty() ? read.error : depth_.Include(read);
    if (wrong.empty() && !options_.size.empty() && read.pixels.size() != options_.size)
      wrong = "is of another size";
    if (wrong.empty() && depth_.guessed())
      wrong =
          "has pixels of 16 bits and does not say how many are used; valid: --bits N of a verb, ?bits=N of "
          "an address";
    if (!wrong.empty()) {
      error_ = images_->names[i] + ' ' + wrong;
      return std::nullopt;
    }
    return Grabbed{depth_.EightBits(read), due_s.value_or(MonotonicNow_s()),
                   static_cast<std::int64_t>(next_)};
  }

  bool Ended() const override { return true; }
  std::string Error() const override { return error_; }

 private:
  // When the image is due, by the first one's grab.
  double WaitForStamp(std::size_t i) {
    if (!begun_s_) begun_s_ = MonotonicNow_s() - images_->Time_s(i);
    const double due_s = *begun_s_ + images_->Time_s(i);
    const double left_s = due_s - MonotonicNow_s();
    if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
    return due_s;
  }

  FolderSourceOptions options_;
  Pace pace_;
  PixelDepth depth_;
  std::shared_ptr<const RecordedImages> images_;
  RecordedImages::Reader read_;
  std::size_t next_ = 0;
  std::optional<double> begun_s_;
  std::string error_;
};

}  // namespace

ImageSourceMaker FolderSource(const FolderSourceOptions& options) {
  return [options] { return std::make_unique<FolderReader>(options); };
}

}  // namespace kestrel::vision
