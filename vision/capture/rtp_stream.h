// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "vision/capture/opencv_source.h"

namespace kestrel::vision {

// A video stream by RTP over UDP: as MJPEG (RFC 2435), or uncoded (RFC 4175, planar 4:2:0), which leaves the
// grey levels as they are and needs a network that carries 1.5 bytes a pixel. It goes to a host and a port;
// whoever receives it listens there.
//
// RTP has a clock of its own, which tells nobody when an image was exposed: a receiver stamps images as they
// come. LiveCameraOptions::exposure_before_stamp_s must then be what lies between, as of any camera that
// gives no stamps: the camera's own delay (of a simulated one, image.latency_s of its scenario) and the
// stream's, RtpDelay_s.
struct RtpStream {
  enum class Coding { kJpeg, kRaw };
  Coding coding = Coding::kJpeg;
  std::string host = "127.0.0.1";  // an address as numbers
  int port = 0;
};

// "rtp:PORT", "raw:PORT", "rtp:ADDRESS:PORT" or "raw:ADDRESS:PORT". None: it is none of these.
std::optional<RtpStream> ParseRtpStream(std::string_view text);
std::string ToText(const RtpStream& stream);  // ParseRtpStream's inverse

// A pipeline of GStreamer that receives it as grey levels or BGR, up to where images are taken. Of an uncoded
// stream the size must be known.
std::string ReceivingPipeline(const RtpStream& stream, cv::Size size, bool colour);
// JPEG has a type of its own (RFC 3551); what has none takes one of those that are free.
RtpPayloads PayloadsOf(RtpStream::Coding coding);
ImageSourceMaker RtpSource(const RtpStream& stream, cv::Size size, bool colour);

// From handing an image to CameraServer until a LiveCamera has it, at 640 x 480 over loopback: about the
// median of `kestrel bench stream` on two cores that had other work. What else there is between is for who
// uses it to measure.
double RtpDelay_s(RtpStream::Coding coding);

}  // namespace kestrel::vision
