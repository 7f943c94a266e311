// SPDX-License-Identifier: Apache-2.0
#include "vision/pad_file.h"

#include <fmt/format.h>

#include <bit>
#include <opencv2/imgcodecs.hpp>

namespace kestrel {

PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes) {
  PadFile pad;
  Read(LoadConfig(file, {}, mistakes), pad.parameters, mistakes);
  pad.texture = file.parent_path() / pad.parameters.texture;
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
  }
  return pad;
}

}  // namespace kestrel
