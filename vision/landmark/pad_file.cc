// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_file.h"

#include <fmt/format.h>

#include <bit>
#include <mutex>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "vision/image_file.h"

namespace kestrel::vision {
namespace {

// The last pad: its corners take longer to find than all else of a scenario to read, and most flights of a
// process are over the same pad as the one before.
struct Kept {
  std::string bytes;  // of the picture's file
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  PadReference reference;
};
std::mutex mutex;
Kept kept;

// Of a picture: smaller shows nothing, and larger is finer than any camera sees and takes a gigabyte.
constexpr int kMinSide_px = 32, kMaxSide_px = 4096;

}  // namespace

PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes) {
  PadFile pad;
  Read(LoadConfig(file, {}, mistakes), pad.parameters, mistakes);
  pad.texture = file.parent_path() / pad.parameters.texture;
  const auto wrong = [&](const std::string& what, const std::string& remedy = {}) {
    mistakes.Add(file.string(), "texture", fmt::format("'{}' {}", pad.texture.string(), what), remedy);
  };
  const FileContent content = ReadUserFile(pad.texture, kMaxDataBytes);
  if (!content.error.empty()) return wrong(content.error), pad;
  {
    const std::lock_guard lock(mutex);
    if (kept.bytes == content.bytes && kept.size_m == pad.parameters.size_m) {
      pad.reference = kept.reference;
      return pad;
    }
  }
  const ImageFile picture = DecodeImage(content.bytes, ImageColours::kGrey, kMaxSide_px);
  const auto is_side = [](int px) {
    return px >= kMinSide_px && std::has_single_bit(static_cast<unsigned>(px));
  };
  if (picture.pixels.empty()) {
    wrong(picture.error);
  } else if (picture.pixels.depth() != CV_8U) {
    wrong("has pixels of 16 bits", "valid: 8");
  } else if (!is_side(picture.pixels.cols) || !is_side(picture.pixels.rows)) {
    wrong(fmt::format("has {} x {} pixels", picture.pixels.cols, picture.pixels.rows),
          fmt::format("valid: sides that are powers of two from {} to {} (2048 x 2048), or OpenGL draws the "
                      "pad askew from far away",
                      kMinSide_px, kMaxSide_px));
  } else {
    pad.reference = MakePadReference(picture.pixels, pad.parameters.size_m.x(), pad.parameters.size_m.y());
    const std::lock_guard lock(mutex);
    kept = {content.bytes, pad.parameters.size_m, pad.reference};
  }
  return pad;
}

}  // namespace kestrel::vision
