// SPDX-License-Identifier: Apache-2.0
#include "vision/write_image.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "base/file/files.h"

namespace kestrel::vision {

namespace fs = std::filesystem;

void WriteImage(const fs::path& file, const cv::Mat& image, const std::vector<int>& parameters) {
  std::vector<uchar> bytes;
  try {
    if (!cv::imencode(file.extension().string(), image, bytes, parameters)) bytes.clear();
  } catch (const cv::Exception&) {
    bytes.clear();
  }
  if (bytes.empty())
    throw std::runtime_error(fmt::format("cannot write {}: it cannot be encoded so", file.string()));
  WriteFile(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace kestrel::vision
