// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/process/piped_process.h"

namespace kestrel::records {

// Reads any video file that the program ffmpeg knows, frame by frame, as the sensor gave it: a rotation that
// the file asks for is not made. Throws std::runtime_error with the file and what ffmpeg said.
class VideoReader {
 public:
  explicit VideoReader(std::filesystem::path file);

  cv::Size size() const { return size_; }
  double rate_hz() const { return rate_hz_; }
  double frames() const { return frames_; }  // about so many, by the file's own word; 0: it does not say

  std::optional<cv::Mat> Next();  // CV_8UC3, blue, green, red; none: the end

 private:
  std::filesystem::path file_;
  cv::Size size_;
  double rate_hz_ = 0, frames_ = 0;
  std::optional<PipedProcess> ffmpeg_;
};

// A size other than this that images of the file have, if there is one: ffmpeg would scale them without a word. It
// decodes those frames alone that need no others. Throws as above.
std::optional<cv::Size> OtherSizeIn(const std::filesystem::path& file, const cv::Size& size);

// When each image of the file is shown, s from the first one. Empty: the file does not say it of each. Throws as above.
std::vector<double> ImageTimesIn(const std::filesystem::path& file);

}  // namespace kestrel::records
