// SPDX-License-Identifier: Apache-2.0
#include "vision/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <system_error>

#include "base/file/files.h"
#include "base/user_file.h"
#include "vision/image_header.h"

namespace kestrel::vision {
namespace {

namespace fs = std::filesystem;

constexpr int kWhiteOf16 = 65535;
constexpr std::array kUsualBits = {8, 10, 12, 14, 16};

int WhiteOf(int bits) { return (1 << bits) - 1; }

// A PNG whose end is missing. Its decoder would say so on the terminal itself.
bool BreaksOff(std::string_view bytes) {
  return bytes.starts_with("\x89PNG") && (bytes.size() < 8 || bytes.substr(bytes.size() - 8, 4) != "IEND");
}

bool IsVideo(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::array kEndings = {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

cv::Mat Decoded(const std::string& bytes, ImageColours colours) {
  const int flags = colours == ImageColours::kGrey     ? cv::IMREAD_GRAYSCALE
                    : colours == ImageColours::kColour ? cv::IMREAD_COLOR
                                                       : cv::IMREAD_ANYCOLOR;
  // Not copied.
  const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  try {
    return cv::imdecode(raw, flags | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

int Largest(const cv::Mat& pixels) {
  double largest = 0;
  cv::minMaxIdx(pixels.reshape(1), nullptr, &largest);
  return static_cast<int>(largest);
}

// Whether values of so many bits were spread over 16, as the PNG specification (12.5) wants it: with zeros or
// with their own upper bits below them.
bool Spread(const cv::Mat& pixels, int bits) {
  const cv::Mat values = pixels.reshape(1);
  return std::all_of(values.begin<std::uint16_t>(), values.end<std::uint16_t>(), [&](std::uint16_t value) {
    const int upper = value >> (16 - bits), lower = value - (upper << (16 - bits));
    return lower == 0 || lower == upper >> (2 * bits - 16);
  });
}

std::optional<int> CertainWhite(const ImageHeader& header, const cv::Mat& pixels) {
  if (pixels.depth() == CV_8U) return WhiteOf(8);
  // Writers that know nothing of the camera say 16 bits, so that says nothing.
  if (header.white && *header.white < kWhiteOf16) return header.white;
  const int largest = Largest(pixels);
  if (header.bits && *header.bits > 8 && *header.bits < 16)
    return largest > WhiteOf(*header.bits) || Spread(pixels, *header.bits) ? kWhiteOf16
                                                                           : WhiteOf(*header.bits);
  // No camera of fewer than 16 bits has more than 14.
  return largest > WhiteOf(14) ? std::optional(kWhiteOf16) : std::nullopt;
}

}  // namespace

ImageFile DecodeImage(const std::string& bytes, ImageColours colours, int most_side_px) {
  ImageFile image;
  const auto header = HeaderOf(bytes);
  if (BreaksOff(bytes)) {
    image.error = "is a damaged image: it breaks off before its end";
  } else if (!header) {
    image.error = fmt::format("is not an image, or a damaged one; valid: {}", kImageFormats);
  } else if (header->size.width > most_side_px || header->size.height > most_side_px) {
    image.error = fmt::format("has {} x {} pixels; valid: up to {} x {}", header->size.width,
                              header->size.height, most_side_px, most_side_px);
  } else if (image.pixels = Decoded(bytes, colours); image.pixels.empty()) {
    image.error = "is a damaged image";
  } else if (image.pixels.depth() != CV_8U && image.pixels.depth() != CV_16U) {
    image = {{}, {}, "has pixels that are neither of 8 nor of 16 bits; valid: one of these"};
  } else {
    image.white = CertainWhite(*header, image.pixels);
  }
  return image;
}

ImageFile ReadImageFile(const fs::path& file, ImageColours colours) {
  std::error_code none;
  if (fs::is_directory(file, none))
    return {{}, {}, fmt::format("is a folder; valid: image files, such as {}", (file / "*.png").string())};
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) return {{}, {}, content.error};
  if (IsVideo(file))
    return {{},
            {},
            "is a video; valid: images. Take some of its frames: ffmpeg -i VIDEO -vf fps=2 frame_%03d.png"};
  return DecodeImage(content.bytes, colours);
}

bool LooksLikeImage(const fs::path& file) { return IsFile(file) && cv::haveImageReader(file.string()); }

bool IsNamedAsImage(const fs::path& file) {
  return IsFile(file) && HasEnding(file, {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm"});
}

std::string PixelDepth::Include(const ImageFile& image) {
  if (image.pixels.empty() || image.pixels.depth() == CV_8U) return {};
  if (bits_) {
    const int largest = Largest(image.pixels);
    return largest <= WhiteOf(*bits_) ? ""
                                      : fmt::format(
                                            "has values up to {}, and {} bits hold {}; valid: more "
                                            "bits",
                                            largest, *bits_, WhiteOf(*bits_));
  }
  if (image.white)
    white_ = white_.value_or(*image.white);
  else
    largest_ = std::max(largest_.value_or(0), Largest(image.pixels));
  return {};
}

int PixelDepth::White() const {
  if (bits_) return WhiteOf(*bits_);
  if (white_) return *white_;
  return WhiteOf(*std::find_if(kUsualBits.begin(), kUsualBits.end(),
                               [&](int bits) { return largest_.value_or(0) <= WhiteOf(bits); }));
}

std::string PixelDepth::Note() const {
  if (!guessed()) return {};
  return fmt::format(
      "16-bit pixels that do not say how many of their bits are used, and go up to {}: white is taken to be "
      "{}; --bits N says it",
      *largest_, White());
}

cv::Mat PixelDepth::EightBits(const ImageFile& image) const {
  if (image.pixels.depth() == CV_8U) return image.pixels;
  const unsigned white = static_cast<unsigned>(!bits_ && image.white ? *image.white : White());
  cv::Mat eight(image.pixels.size(), CV_8UC(image.pixels.channels()));
  // The upper eight of the bits, as decoders give them of 16.
  const cv::Mat from = image.pixels.reshape(1);
  cv::Mat to = eight.reshape(1);
  std::transform(from.begin<std::uint16_t>(), from.end<std::uint16_t>(), to.begin<std::uint8_t>(),
                 [&](unsigned value) { return std::min(255u, value * 256 / (white + 1)); });
  return eight;
}

cv::Mat ReadImage(const std::string& file, ImageColours colours, std::optional<int> bits, Mistakes& mistakes,
                  std::string& note) {
  const ImageFile image = ReadImageFile(file, colours);
  PixelDepth depth(bits);
  const std::string error = image.pixels.empty() ? image.error : depth.Include(image);
  if (!error.empty()) {
    mistakes.Add(file, "", error);
    return {};
  }
  note = depth.Note();
  return depth.EightBits(image);
}

cv::Mat ReadMask(const fs::path& file, const Place& where, std::string_view key, Mistakes& mistakes) {
  const ImageFile image = ReadImageFile(file, ImageColours::kGrey);
  if (!image.pixels.empty()) return image.pixels > 0;
  mistakes.Add(where, key, fmt::format("'{}' {}", file.string(), image.error));
  return {};
}

}  // namespace kestrel::vision
