// SPDX-License-Identifier: Apache-2.0
#include "scenarios/read_image.h"

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "scenarios/files.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

// A PNG whose end is missing. Its decoder would say so on the terminal itself.
bool BreaksOff(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  char begin[8] = {}, end[8] = {};
  in.read(begin, sizeof begin);
  if (!in || std::string_view(begin, 8) != "\x89PNG\r\n\x1a\n") return false;
  in.seekg(-8, std::ios::end);
  in.read(end, sizeof end);
  return !in || std::string_view(end, 4) != "IEND";
}

}  // namespace

bool LooksLikeImage(const std::string& file) { return cv::haveImageReader(file); }

cv::Mat ReadImage(const std::string& file, int flags, Mistakes& mistakes) {
  std::error_code none;
  cv::Mat image;
  if (fs::is_directory(file, none)) {
    mistakes.Add(file, "", "is a folder; valid: image files, such as " + (fs::path(file) / "*.png").string());
  } else if (!fs::is_regular_file(file, none)) {
    mistakes.Add(file, "", "there is no such file");
  } else if (BreaksOff(file)) {
    mistakes.Add(file, "", "is a damaged image: it breaks off before its end");
  } else if (image = cv::imread(file, flags | cv::IMREAD_IGNORE_ORIENTATION); image.empty()) {
    if (HasEnding(file, {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg"}))
      mistakes.Add(file, "",
                   "is a video; valid: images. Take some of its frames: ffmpeg -i VIDEO -vf fps=2 "
                   "frame_%03d.png");
    else
      mistakes.Add(file, "", LooksLikeImage(file) ? "is a damaged image" : "is not an image");
  }
  return image;
}

}  // namespace kestrel
