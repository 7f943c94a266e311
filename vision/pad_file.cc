// SPDX-License-Identifier: Apache-2.0
#include "vision/pad_file.h"

#include <fmt/format.h>

#include <bit>
#include <fstream>
#include <iterator>
#include <mutex>
#include <opencv2/imgcodecs.hpp>

namespace kestrel {
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

std::string ContentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes) {
  PadFile pad;
  Read(LoadConfig(file, {}, mistakes), pad.parameters, mistakes);
  pad.texture = file.parent_path() / pad.parameters.texture;
  const Kept wanted{ContentOf(pad.texture), pad.parameters.size_m, {}};
  {
    const std::lock_guard lock(mutex);
    if (!wanted.bytes.empty() && kept.bytes == wanted.bytes && kept.size_m == wanted.size_m) {
      pad.reference = kept.reference;
      return pad;
    }
  }
  const cv::Mat picture = cv::imread(pad.texture.string(), cv::IMREAD_GRAYSCALE);
  if (picture.empty()) {
    mistakes.Add(file.string(), "texture",
                 fmt::format("{} cannot be read as an image", pad.texture.string()));
  } else if (!std::has_single_bit(static_cast<unsigned>(picture.cols)) ||
             !std::has_single_bit(static_cast<unsigned>(picture.rows))) {
    mistakes.Add(
        file.string(), "texture",
        fmt::format(
            "{} has {} x {} pixels; the sides must be powers of two (2048 x 2048), or OpenGL draws the "
            "pad askew from far away",
            pad.texture.string(), picture.cols, picture.rows));
  } else {
    pad.reference = MakePadReference(picture, pad.parameters.size_m.x(), pad.parameters.size_m.y());
    const std::lock_guard lock(mutex);
    kept = {wanted.bytes, wanted.size_m, pad.reference};
  }
  return pad;
}

}  // namespace kestrel
