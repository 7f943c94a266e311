// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "vision/capture/rtp_filter.h"

namespace kestrel::vision {

// A pipeline of GStreamer and the images that come out of its appsink. Whatever comes in, it holds no more
// than its elements do: what they have to say is heard as they say it and thrown away, which would else wait
// on the pipeline's bus, a warning for each packet that is none. Used by one thread at a time.
class GStreamerPipeline {
 public:
  static constexpr double kSilent_s = 8;  // how long an image is waited for

  GStreamerPipeline();
  ~GStreamerPipeline();
  GStreamerPipeline(const GStreamerPipeline&) = delete;
  GStreamerPipeline& operator=(const GStreamerPipeline&) = delete;

  // Plays it, as gst-launch-1.0 would, until its first image is there. Its UDP sockets take nothing but RTP
  // of these types, where any are given. False: Error() says why.
  bool Open(const std::string& description, const std::optional<RtpPayloads>& payloads);

  // The next image, CV_8UC1 or CV_8UC3 in the order blue, green, red. Empty: none comes, and Error() says
  // why.
  cv::Mat Next();

  const std::string& Error() const { return error_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string error_;
};

}  // namespace kestrel::vision
