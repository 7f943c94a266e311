// SPDX-License-Identifier: Apache-2.0
#include "sim/world/decoded_texture.h"

#include <xxhash.h>

#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "base/recent/recent.h"
#include "vision/image_file.h"

namespace kestrel::sim {
namespace {

using Key = std::pair<std::uint64_t, std::uint64_t>;
constexpr std::size_t kKept = 4;

std::string Decode(const std::string& png) {
  const vision::ImageFile image = vision::DecodeImage(png, vision::ImageColours::kColour);
  if (!png.starts_with("\x89PNG") || image.pixels.empty() || image.pixels.depth() != CV_8U) return {};
  const std::int32_t sides[] = {image.pixels.cols, image.pixels.rows};
  std::string texture(sizeof sides + 3 * image.pixels.total(), '\0');
  std::memcpy(texture.data(), sides, sizeof sides);
  cv::Mat rgb(image.pixels.size(), CV_8UC3, texture.data() + sizeof sides);
  cv::cvtColor(image.pixels, rgb, image.pixels.channels() == 1 ? cv::COLOR_GRAY2RGB : cv::COLOR_BGR2RGB);
  return texture;
}

}  // namespace

std::shared_ptr<const std::string> DecodedTexture(const std::string& png) {
  static Recent<Key, std::string> recent(kKept);
  const XXH128_hash_t hash = XXH3_128bits(png.data(), png.size());
  auto texture = recent.Of({hash.high64, hash.low64}, [&] { return Decode(png); });
  return texture->empty() ? nullptr : texture;
}

}  // namespace kestrel::sim
