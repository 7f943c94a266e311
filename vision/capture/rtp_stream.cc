// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/rtp_stream.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>

namespace kestrel::vision {
namespace {

// Only what is an address may stand in a pipeline.
bool IsAddress(const std::string& text) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, text.c_str(), bytes) == 1 || inet_pton(AF_INET6, text.c_str(), bytes) == 1;
}

}  // namespace

std::optional<RtpStream> ParseRtpStream(std::string_view text) {
  RtpStream stream;
  if (text.starts_with("raw:")) {
    stream.coding = RtpStream::Coding::kRaw;
  } else if (!text.starts_with("rtp:")) {
    return std::nullopt;
  }
  text.remove_prefix(4);
  if (const std::size_t colon = text.rfind(':'); colon != std::string_view::npos) {
    stream.host = text.substr(0, colon);
    text.remove_prefix(colon + 1);
  }
  const auto end = std::from_chars(text.data(), text.data() + text.size(), stream.port);
  if (end.ec != std::errc{} || end.ptr != text.data() + text.size() || stream.port < 1 ||
      stream.port > 65535 || !IsAddress(stream.host))
    return std::nullopt;
  return stream;
}

std::string ToText(const RtpStream& stream) {
  return fmt::format("{}:{}{}", stream.coding == RtpStream::Coding::kRaw ? "raw" : "rtp",
                     stream.host == RtpStream{}.host ? "" : stream.host + ":", stream.port);
}

std::string ReceivingPipeline(const RtpStream& stream, cv::Size size, bool colour) {
  const bool raw = stream.coding == RtpStream::Coding::kRaw;
  const std::string caps = raw ? fmt::format(
                                     "encoding-name=RAW,sampling=(string)YCbCr-4:2:0,depth=(string)8,"
                                     "width=(string){},height=(string){},colorimetry=(string)BT601-5",
                                     size.width, size.height)
                               : "encoding-name=JPEG,payload=26";
  // An image comes in one go: what the socket cannot hold of it is lost. The jitter buffer passes on at once
  // what comes in its order, waits for what is missing, and throws away what comes twice. Decoding has a
  // thread of its own and takes the newest: on a busy processor images would else wait in the socket, tens of
  // them.
  return fmt::format(
      "udpsrc address={} port={} buffer-size=4194304 caps=\"application/x-rtp,media=video,clock-rate=90000,"
      "{}\" ! rtpjitterbuffer latency=5 ! {} ! queue leaky=downstream max-size-buffers=1 max-size-bytes=0 "
      "max-size-time=0 ! {}videoconvert ! video/x-raw,format={}",
      stream.host, stream.port, caps, raw ? "rtpvrawdepay" : "rtpjpegdepay", raw ? "" : "jpegdec ! ",
      colour ? "BGR" : "GRAY8");
}

RtpPayloads PayloadsOf(RtpStream::Coding coding) {
  return coding == RtpStream::Coding::kRaw ? RtpPayloads{96, 127} : RtpPayloads{26, 26};
}

ImageSourceMaker RtpSource(const RtpStream& stream, cv::Size size, bool colour) {
  OpenCvSourceOptions options;
  options.kind = OpenCvSourceOptions::Kind::kGStreamer;
  options.host = stream.host, options.port = stream.port;
  options.payloads = PayloadsOf(stream.coding);
  options.what = ReceivingPipeline(stream, size, colour);
  options.size = size;
  options.colour = colour;
  return OpenCvSource(options);
}

double RtpDelay_s(RtpStream::Coding coding) { return coding == RtpStream::Coding::kRaw ? 0.003 : 0.006; }

}  // namespace kestrel::vision
