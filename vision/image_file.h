// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/diagnostics.h"

// Image files of a user, refused before they are decoded if their pixels would take much memory.
namespace kestrel::vision {

// The sides of the largest image that any camera has.
constexpr int kMaxImageSide_px = 8192;

enum class ImageColours { kGrey, kColour, kAsStored };  // as stored: grey or colour

struct ImageFile {
  cv::Mat pixels;  // CV_8U or CV_16U, 1 channel or blue, green, red; never turned by what its camera noted.
                   // Empty: it could not be read
  std::optional<int> white;  // the value of full white, where it is certain
  std::string error;         // why there are no pixels: "is a damaged image", "is not an image; valid: ..."
};
ImageFile DecodeImage(const std::string& bytes, ImageColours colours, int most_side_px = kMaxImageSide_px);
// Says of what is no image what it is instead.
ImageFile ReadImageFile(const std::filesystem::path& file, ImageColours colours);

// Whether a file begins as images do, whole or not.
bool LooksLikeImage(const std::filesystem::path& file);
// Whether its name ends as those of images do, whatever is in it.
bool IsNamedAsImage(const std::filesystem::path& file);

// Of the images of one camera, what their pixels of 16 bits mean. Cameras of 10, 12 or 14 bits mostly leave
// the upper bits empty, and files mostly do not say it. What one image says holds for all of them, so that
// none is brighter than another because of what is in it.
class PixelDepth {
 public:
  // bits: of the camera; none: by what the files say, or else by the largest value in any of them.
  explicit PixelDepth(std::optional<int> bits = std::nullopt) : bits_(bits) {}

  // All images first. Empty: its values fit, or why they do not.
  std::string Include(const ImageFile& image);
  // Whether the largest value alone decides. Then it is to be said, by Note.
  bool guessed() const { return !bits_ && !white_ && largest_; }
  std::string Note() const;

  cv::Mat EightBits(const ImageFile& image) const;

 private:
  int White() const;

  std::optional<int> bits_, white_, largest_;  // given; said by an image; of those that do not say
};

// One image of which nothing else depends: of 8 bits. Empty: a mistake says why. note: what PixelDepth says.
cv::Mat ReadImage(const std::string& file, ImageColours colours, std::optional<int> bits, Mistakes& mistakes,
                  std::string& note);

// A mask: 255 where the image is not black, otherwise 0. Empty: a mistake says why.
cv::Mat ReadMask(const std::filesystem::path& file, const Place& where, std::string_view key,
                 Mistakes& mistakes);

}  // namespace kestrel::vision
