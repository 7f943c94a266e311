// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "vision/capture/image_source.h"

namespace kestrel::vision {

struct RecordedImages;

// The images of a recording one after the other (vision/capture/recorded/recorded_images.h): of a data set, or
// of a folder by name. An image that cannot be read, of another size, or of pixels in 16 bits whose meaning
// neither it nor the first image nor `bits` says (PixelDepth), is a failure: images that come one by one are
// not judged by their largest value, which the next one may exceed.
// After a failure of one image the next can be grabbed.
struct FolderSourceOptions {
  std::filesystem::path images;
  std::string topic = {};  // which camera of several; empty: the only one
  std::shared_ptr<const RecordedImages> opened =
      nullptr;         // the same, where it is open; null: the source opens it
  cv::Size size;       // empty: as they come
  double rate_hz = 0;  // the pace at which they come; 0: as fast as taken
  // Of a recording with stamps: they come as they were recorded, and are stamped by the monotonic clock as far
  // from one another, to the nanosecond.
  bool as_recorded = false;
  bool colour = false;
  std::optional<int> bits = std::nullopt;  // of pixels in 16 bits; none: as the first image says
};

ImageSourceMaker FolderSource(const FolderSourceOptions& options);

}  // namespace kestrel::vision
