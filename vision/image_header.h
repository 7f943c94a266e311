// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace kestrel::vision {

// What an image file says of itself before its pixels are decoded, which may be many more than it has bytes.
struct ImageHeader {
  cv::Size size;  // of the image, or of a tile of it that is larger
  // Of pixels in 16 bits, where the file says it: how many of the bits mean something (PNG: sBIT; TIFF: fewer
  // than 16), and the value of full white (PGM, PPM).
  std::optional<int> bits = std::nullopt, white = std::nullopt;
};

// Of PNG, JPEG, TIFF, BMP, PGM, PPM and WebP; none: it is none of these, or its header is cut.
std::optional<ImageHeader> HeaderOf(std::string_view file);

constexpr const char* kImageFormats = "PNG, JPEG, TIFF, BMP, PGM, PPM, WebP";

}  // namespace kestrel::vision
