// SPDX-License-Identifier: Apache-2.0
#include "vision/image_header.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <climits>
#include <cstdint>
#include <cstdlib>

namespace kestrel::vision {
namespace {

// Bytes of a file by their places; what lies beyond its end is 0, and the reader then no longer whole.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::uint64_t Big(std::size_t at, std::size_t count) { return Number(at, count, true); }
  std::uint64_t Little(std::size_t at, std::size_t count) { return Number(at, count, false); }
  std::uint64_t Number(std::size_t at, std::size_t count, bool big) {
    if (at > bytes_.size() || count > bytes_.size() - at) return whole_ = false, 0;
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < count; ++i)
      number = number << 8 | static_cast<unsigned char>(bytes_[at + (big ? i : count - 1 - i)]);
    return number;
  }
  bool Has(std::size_t at, std::string_view text) const {
    return at <= bytes_.size() && bytes_.substr(at).starts_with(text);
  }
  std::size_t size() const { return bytes_.size(); }
  std::string_view text() const { return bytes_; }
  bool whole() const { return whole_; }

 private:
  std::string_view bytes_;
  bool whole_ = true;
};

int Side(std::uint64_t px) { return static_cast<int>(std::min<std::uint64_t>(px, INT_MAX)); }

cv::Size SizeOf(std::uint64_t width, std::uint64_t height) { return {Side(width), Side(height)}; }

// PNG specification, 11.2.2 and 11.3.3.4.
ImageHeader OfPng(Bytes& file) {
  ImageHeader header{SizeOf(file.Big(16, 4), file.Big(20, 4))};
  if (file.Big(24, 1) != 16) return header;
  for (std::size_t at = 8; file.whole() && !file.Has(at + 4, "IDAT"); at += 12 + file.Big(at, 4)) {
    if (!file.Has(at + 4, "sBIT") || file.Big(at, 4) == 0) continue;
    header.bits = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(file.Big(at, 4), 3); ++i)
      header.bits = std::max(*header.bits, static_cast<int>(file.Big(at + 8 + i, 1)));
    break;
  }
  return header;
}

// ITU-T T.81, B.1.1.3 and B.2.2: the first marker of a frame.
ImageHeader OfJpeg(Bytes& file) {
  std::size_t at = 2;
  while (file.whole()) {
    while (at < file.size() && file.Big(at, 1) != 0xff) ++at;  // what decoders pass over too
    while (at < file.size() && file.Big(at, 1) == 0xff) ++at;
    const std::uint64_t marker = file.Big(at++, 1);
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc)
      return {SizeOf(file.Big(at + 5, 2), file.Big(at + 3, 2))};
    const bool alone = marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (!alone) at += file.Big(at, 2);
  }
  return {};
}

// TIFF 6.0: the first image's directory.
ImageHeader OfTiff(Bytes& file, bool big) {
  ImageHeader header;
  const std::size_t directory = file.Number(4, 4, big);
  const std::uint64_t entries = file.Number(directory, 2, big);
  for (std::size_t i = 0; i < entries && file.whole(); ++i) {
    const std::size_t at = directory + 2 + 12 * i;
    const std::uint64_t tag = file.Number(at, 2, big), type = file.Number(at + 2, 2, big);
    const std::uint64_t count = file.Number(at + 4, 4, big);
    constexpr std::uint64_t kByte = 1, kShort = 3, kWidth = 256, kHeight = 257, kBits = 258, kTileWidth = 322,
                            kTileHeight = 323;
    const std::size_t bytes = type == kByte ? 1 : type == kShort ? 2 : 4;
    const std::size_t value_at = count * bytes > 4 ? file.Number(at + 8, 4, big) : at + 8;
    const std::uint64_t value = file.Number(value_at, bytes, big);
    if (tag == kWidth || tag == kTileWidth) header.size.width = std::max(header.size.width, Side(value));
    if (tag == kHeight || tag == kTileHeight) header.size.height = std::max(header.size.height, Side(value));
    if (tag == kBits && value > 8 && value < 16) header.bits = static_cast<int>(value);
  }
  return header;
}

ImageHeader OfBitmap(Bytes& file) {
  constexpr std::uint64_t kOfOs2 = 12;
  if (file.Little(14, 4) == kOfOs2) return {SizeOf(file.Little(18, 2), file.Little(20, 2))};
  const auto height = static_cast<std::int32_t>(file.Little(22, 4));  // below 0: from the top
  return {SizeOf(file.Little(18, 4), static_cast<std::uint64_t>(std::llabs(height)))};
}

// Netpbm: three numbers as text, two of a bitmap, between them blanks and comments.
std::optional<ImageHeader> OfNetpbm(std::string_view text) {
  const bool has_white = text[1] != '1' && text[1] != '4';
  int numbers[3] = {0, 0, 1};
  text.remove_prefix(2);
  for (int i = 0; i < (has_white ? 3 : 2); ++i) {
    while (!text.empty() && (std::isspace(static_cast<unsigned char>(text[0])) || text[0] == '#'))
      text.remove_prefix(text[0] == '#' ? std::min(text.find('\n'), text.size()) : 1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), numbers[i]);
    if (error == std::errc::result_out_of_range) numbers[i] = INT_MAX;
    if (error == std::errc::invalid_argument) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  ImageHeader header{{numbers[0], numbers[1]}};
  if (numbers[2] > 255) header.white = numbers[2];
  return header;
}

// RFC 9649: the three kinds of first chunk.
ImageHeader OfWebp(Bytes& file) {
  if (file.Has(12, "VP8X")) return {SizeOf(1 + file.Little(24, 3), 1 + file.Little(27, 3))};
  if (file.Has(12, "VP8L")) {
    const std::uint64_t bits = file.Little(21, 4);
    return {SizeOf(1 + (bits & 0x3fff), 1 + (bits >> 14 & 0x3fff))};
  }
  return {SizeOf(file.Little(26, 2) & 0x3fff, file.Little(28, 2) & 0x3fff)};
}

std::optional<ImageHeader> Parsed(Bytes& file) {
  using namespace std::string_view_literals;
  if (file.Has(0, "\x89PNG\r\n\x1a\n") && file.Has(12, "IHDR")) return OfPng(file);
  if (file.Has(0, "\xff\xd8\xff")) return OfJpeg(file);
  if (file.Has(0, "II*\0"sv)) return OfTiff(file, false);
  if (file.Has(0, "MM\0*"sv)) return OfTiff(file, true);
  if (file.Has(0, "BM")) return OfBitmap(file);
  if (file.Has(0, "RIFF") && file.Has(8, "WEBPVP8")) return OfWebp(file);
  if (file.size() > 2 && file.text()[0] == 'P' && file.text()[1] >= '1' && file.text()[1] <= '6')
    return OfNetpbm(file.text());
  return std::nullopt;
}

}  // namespace

std::optional<ImageHeader> HeaderOf(std::string_view bytes) {
  Bytes file(bytes);
  const auto header = Parsed(file);
  if (!header || !file.whole() || header->size.width < 1 || header->size.height < 1) return std::nullopt;
  return header;
}

}  // namespace kestrel::vision
