// SPDX-License-Identifier: Apache-2.0
#include "records/video/video.h"

#include <fmt/format.h>

#include <cassert>
#include <stdexcept>

#include "base/file/files.h"

namespace kestrel::records {
namespace {

// A browser finds a frame at 640 x 480 in some 15 ms then, and in up to 300 ms with x264's own 250.
constexpr int kMostBetweenKeyFrames = 15;

}  // namespace

template <class Action>
void Video::Named(Action action) const {
  try {
    action();
  } catch (const std::runtime_error& e) {
    std::error_code none;
    std::filesystem::remove(PartOf(file_), none);  // it plays nowhere
    throw std::runtime_error(fmt::format("cannot write {}: {}", file_.string(), e.what()));
  }
}

void Video::Write(const cv::Mat& bgr) {
  assert(bgr.type() == CV_8UC3);
  Named([&] {
    if (!ffmpeg_) {
      size_ = bgr.size();
      // The pad filter: yuv420p has half the colour pixels each way, so it wants an even size.
      std::vector<std::string> command = {"ffmpeg",
                                          "-loglevel",
                                          "error",
                                          "-xerror",  // a disk that is full at the end is a failure too
                                          "-y",
                                          "-f",
                                          "rawvideo",
                                          "-pix_fmt",
                                          "bgr24",
                                          "-video_size",
                                          fmt::format("{}x{}", size_.width, size_.height),
                                          "-framerate",
                                          fmt::format("{}", rate_hz_),
                                          "-i",
                                          "pipe:0",
                                          "-vf",
                                          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                          "-c:v",
                                          "libx264",
                                          "-preset",
                                          "veryfast",
                                          "-crf",
                                          most_kbit_s_ ? "24" : "23",
                                          "-pix_fmt",
                                          "yuv420p"};
      if (most_kbit_s_)
        command.insert(command.end(), {"-g", fmt::format("{}", kMostBetweenKeyFrames), "-maxrate",
                                       fmt::format("{}k", *most_kbit_s_), "-bufsize",
                                       fmt::format("{}k", 2 * *most_kbit_s_)});
      command.insert(command.end(),
                     {"-movflags", "+faststart", "-f", "mp4", "file:" + PartOf(file_).string()});
      ffmpeg_.emplace(command);
    }
    if (bgr.size() != size_) {
      throw std::runtime_error(fmt::format("a frame of {}x{} px follows frames of {}x{} px", bgr.cols,
                                           bgr.rows, size_.width, size_.height));
    }
    for (int row = 0; row < bgr.rows; ++row) {
      ffmpeg_->Write({bgr.ptr<char>(row), static_cast<std::size_t>(bgr.cols) * bgr.elemSize()});
    }
  });
}

void Video::Close() {
  if (!ffmpeg_) return;
  Named([&] { ffmpeg_->Close(); });
  ffmpeg_.reset();
  Complete(file_);
}

}  // namespace kestrel::records
