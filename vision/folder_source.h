// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "vision/image_source.h"

namespace kestrel {

// The images of a folder one after the other, by name, numbers in the names by their value. What is not an
// image is passed over; an image that cannot be read, or of another size, is a failure.
struct FolderSourceOptions {
  std::filesystem::path folder;
  cv::Size size;       // empty: as they come
  double rate_hz = 0;  // the pace at which they come; 0: as fast as taken
  bool colour = false;
};

ImageSourceMaker FolderSource(const FolderSourceOptions& options);

}  // namespace kestrel
