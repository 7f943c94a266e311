// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/raw_image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

namespace kestrel::vision {
namespace {

struct Encoding {
  const char* name;
  int type;                   // as it lies in the message
  std::optional<int> to_bgr;  // cv::cvtColor's code; none: it is grey, or blue, green, red
};

// A mosaic is named by its first two rows in ROS, and by its second row's middle in OpenCV.
const std::vector<Encoding>& Encodings() {
  static const std::vector<Encoding> kEncodings = {{"mono8", CV_8UC1, {}},
                                                   {"mono16", CV_16UC1, {}},
                                                   {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
                                                   {"bgr8", CV_8UC3, {}},
                                                   {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
                                                   {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
                                                   {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR},
                                                   {"bgr16", CV_16UC3, {}},
                                                   {"rgba16", CV_16UC4, cv::COLOR_RGBA2BGR},
                                                   {"bgra16", CV_16UC4, cv::COLOR_BGRA2BGR},
                                                   {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
                                                   {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
                                                   {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
                                                   {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
                                                   {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
                                                   {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
                                                   {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
                                                   {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR},
                                                   {"8UC1", CV_8UC1, {}},
                                                   {"16UC1", CV_16UC1, {}},
                                                   {"8UC3", CV_8UC3, {}}};
  return kEncodings;
}

ImageFile Refused(const std::string& why) { return {{}, {}, why}; }

// Whether a size is one of images, and the data hold it; otherwise why not.
std::string WrongSize(const RawImage& image, std::size_t pixel_bytes) {
  if (image.width_px == 0 || image.height_px == 0) return "has no pixels";
  if (image.width_px > kMaxImageSide_px || image.height_px > kMaxImageSide_px)
    return fmt::format("has {} x {} pixels; valid: up to {} x {}", image.width_px, image.height_px,
                       kMaxImageSide_px, kMaxImageSide_px);
  const std::size_t row = image.width_px * pixel_bytes;
  const std::size_t whole = std::size_t{image.step} * (image.height_px - 1) + row;
  if (image.step < row)
    return fmt::format("has rows of {} bytes; valid: {} or more, for {} pixels of {}", image.step, row,
                       image.width_px, image.encoding);
  if (image.data.size() < whole)
    return fmt::format("has {} bytes; valid: {} or more, for {} x {} pixels of {}", image.data.size(), whole,
                       image.width_px, image.height_px, image.encoding);
  return "";
}

}  // namespace

ImageFile DecodeRawImage(const RawImage& image, ImageColours colours) {
  const auto& known = Encodings();
  const auto encoding = std::find_if(known.begin(), known.end(),
                                     [&](const Encoding& each) { return image.encoding == each.name; });
  if (encoding == known.end()) {
    std::vector<std::string> names;
    for (const Encoding& each : known) names.emplace_back(each.name);
    return Refused(fmt::format("has the encoding '{}'; valid: {}", image.encoding, fmt::join(names, ", ")));
  }
  if (const std::string wrong = WrongSize(image, CV_ELEM_SIZE(encoding->type)); !wrong.empty())
    return Refused(wrong);
  // The message's bytes are not written to: cv::Mat knows no constant ones.
  const cv::Mat there(static_cast<int>(image.height_px), static_cast<int>(image.width_px), encoding->type,
                      const_cast<char*>(image.data.data()),  // NOLINT(cppcoreguidelines-pro-type-const-cast)
                      image.step);
  const bool deep = CV_MAT_DEPTH(encoding->type) == CV_16U;
  cv::Mat pixels = there.clone();
  if (deep && image.big_endian != (std::endian::native == std::endian::big)) {
    cv::Mat_<std::uint16_t> values = pixels.reshape(1);
    for (std::uint16_t& value : values) value = static_cast<std::uint16_t>(value << 8 | value >> 8);
  }
  if (encoding->to_bgr) cv::cvtColor(pixels.clone(), pixels, *encoding->to_bgr);
  if (colours == ImageColours::kGrey && pixels.channels() == 3)
    cv::cvtColor(pixels.clone(), pixels, cv::COLOR_BGR2GRAY);
  if (colours == ImageColours::kColour && pixels.channels() == 1)
    cv::cvtColor(pixels.clone(), pixels, cv::COLOR_GRAY2BGR);
  return {pixels, deep ? std::nullopt : std::optional(255), ""};
}

}  // namespace kestrel::vision
