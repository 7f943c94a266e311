// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "vision/capture/image_source.h"
#include "vision/capture/rtp_filter.h"

namespace kestrel::vision {

// What OpenCV's capture can open. Width, height and rate are asked of the device and must then be given: an
// image of another size is a failure, since it would meet the wrong calibration.
struct OpenCvSourceOptions {
  enum class Kind { kV4l2, kGStreamer, kIeee1394, kFile } kind = Kind::kV4l2;
  std::string
      what;  // device ("/dev/video0"), pipeline up to its appsink, number of the camera, or file of a video
  std::string host = {};  // of a pipeline that listens at a UDP port, which nobody else may then do
  int port = 0;           // 0: it does not
  std::optional<RtpPayloads> payloads = {};  // of RTP, what it takes there: all else the kernel throws away
  cv::Size size;                             // of the images; empty: as they come
  double rate_hz = 0;  // 0: as the device likes. Of a file: the pace at which it is read, 0: as fast as taken
  bool colour = false;  // CV_8UC3, otherwise CV_8UC1
};

// Time stamps: V4L2's own, nearly always of the monotonic clock; the others' images are stamped as they come.
// A pipeline gets "appsink drop=true max-buffers=1 sync=false" at its end unless it has an appsink.
ImageSourceMaker OpenCvSource(const OpenCvSourceOptions& options);

}  // namespace kestrel::vision
