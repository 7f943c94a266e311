// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/capture/image_source.h"

namespace kestrel::vision {

// The images of a folder one after the other, by name, numbers in the names by their value; or those of them
// whose names a pattern with one number matches ("image%04d.png"), or one image alone. What is not an
// image, nor named as one, is passed over; an image that cannot be read, of another size, or of pixels in 16 bits whose meaning
// neither it nor the first image nor `bits` says (PixelDepth), is a failure: images that come one by one are
// not judged by their largest value, which the next one may exceed.
// After a failure of one image the next can be grabbed.
struct FolderSourceOptions {
  std::filesystem::path images;
  cv::Size size;       // empty: as they come
  double rate_hz = 0;  // the pace at which they come; 0: as fast as taken
  bool colour = false;
  std::optional<int> bits = std::nullopt;  // of pixels in 16 bits; none: as the first image says
};

ImageSourceMaker FolderSource(const FolderSourceOptions& options);

}  // namespace kestrel::vision
