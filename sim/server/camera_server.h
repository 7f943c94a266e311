// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <thread>

#include "vision/capture/rtp_stream.h"

namespace kestrel::sim {

// Sends images as a video stream. Coding and sending are on a thread of their own and delay nobody: when an
// image comes before the one before has been sent, the newer one wins and the other is counted.
class CameraServer {
 public:
  // The rate is what the stream says of itself. Throws std::runtime_error where GStreamer or its plugins are
  // not there.
  CameraServer(const vision::RtpStream& stream, cv::Size size, double rate_hz, bool colour);
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  void Publish(const cv::Mat& image);  // CV_8UC1 or CV_8UC3 of the size; returns at once

  std::int64_t sent() const;
  std::int64_t overwritten() const;
  const vision::RtpStream& stream() const { return stream_; }

 private:
  void Work(cv::Size size, double rate_hz, bool colour);

  vision::RtpStream stream_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  cv::Mat waiting_;  // empty: none
  std::int64_t sent_ = 0, overwritten_ = 0;
  enum class Stage { kOpening, kOpen, kRefused } stage_ = Stage::kOpening;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace kestrel::sim
