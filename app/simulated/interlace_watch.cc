// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/interlace_watch.h"

#include <fmt/format.h>

#include "vision/interlaced.h"

namespace kestrel::app {

bool InterlaceWatch::Add(const cv::Mat& image) {
  const bool interlaced = vision::Interlaced(image);
  ++images_, interlaced_ += interlaced;
  return interlaced;
}

std::string InterlaceWatch::Sentence(const std::string& input) const {
  constexpr double kMinShare = 0.05;
  if (interlaced_ < 2 || interlaced_ < kMinShare * images_) return "";
  return fmt::format(
      "interlaced: {} of {} images are woven of two fields of different times; --deinterlace takes the first "
      "field alone, and ffmpeg -i {} -vf yadif WHOLE.mp4 makes whole images of both",
      interlaced_, images_, input);
}

}  // namespace kestrel::app
