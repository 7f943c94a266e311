// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "base/process/piped_process.h"

namespace kestrel::records {

// Writes a video (H.264 in MP4, playable while it loads) through the program ffmpeg. The file has its final
// name only once it is complete, and nothing of it remains where writing failed. Throws std::runtime_error with the
// file and what ffmpeg said.
class Video {
 public:
  // most_kbit_s: of a video that is looked at frame by frame within a page. No frame is far from one that stands by
  // itself then, and what would be larger loses detail instead. None: as large as it needs.
  Video(std::filesystem::path file, double rate_hz, std::optional<int> most_kbit_s = {})
      : file_(std::move(file)), rate_hz_(rate_hz), most_kbit_s_(most_kbit_s) {}

  void Write(const cv::Mat& bgr);  // CV_8UC3, all of one size
  void Close();                    // without any frame there is no file

 private:
  template <class Action>
  void Named(Action action) const;

  std::filesystem::path file_;
  double rate_hz_;
  std::optional<int> most_kbit_s_;
  cv::Size size_;
  std::optional<PipedProcess> ffmpeg_;
};

}  // namespace kestrel::records
