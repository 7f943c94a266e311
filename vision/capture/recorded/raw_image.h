// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "vision/image_file.h"

namespace kestrel::vision {

// The pixels of sensor_msgs/Image, as they lie in the message.
struct RawImage {
  std::uint32_t width_px = 0, height_px = 0;
  std::uint32_t step = 0;  // bytes from row to row
  std::string encoding;    // of sensor_msgs/image_encodings
  bool big_endian = false;
  std::string_view data;
};

// Of mono8, mono16, rgb8, bgr8, rgba8, bgra8, the same with 16 bits, bayer_rggb8 and the like, and 8UC1, 16UC1,
// 8UC3 (blue, green, red). Other encodings are refused by name, and so is an image whose data are not as large
// as it says. What fewer than 16 bits fill, no encoding says: white is not known then.
ImageFile DecodeRawImage(const RawImage& image, ImageColours colours);

}  // namespace kestrel::vision
