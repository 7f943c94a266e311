// SPDX-License-Identifier: Apache-2.0
#include "sim/server/camera_server.h"

#include <fmt/format.h>

#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <utility>

namespace kestrel::sim {
namespace {

// Neither coding knows grey images: they go as luminance, unchanged, with colour that is none. 1:4:0:0: the
// full range, which decoders of JPEG take for granted. sync=false: an image goes out when it comes, not when
// its place in the stream says. Within
// this computer packets may be large: the fewer there are, the fewer are lost.
std::string SendingPipeline(const vision::RtpStream& stream) {
  const bool raw = stream.coding == vision::RtpStream::Coding::kRaw;
  const bool here = stream.host.starts_with("127.") || stream.host == "::1";
  const int packet = here ? 60000 : 1400;
  // Nobody beyond this computer has anything to say to a stream within it.
  const std::string bind = !here                  ? ""
                           : stream.host == "::1" ? "bind-address=::1 "
                                                  : "bind-address=127.0.0.1 ";
  return fmt::format(
      "appsrc ! videoconvert ! video/x-raw,format=I420{} mtu={} ! udpsink host={} port={} {}sync=false "
      "async=false buffer-size=4194304",
      raw ? " ! rtpvrawpay" : ",colorimetry=(string)1:4:0:0 ! jpegenc quality=95 ! rtpjpegpay", packet,
      stream.host, stream.port, bind);
}

}  // namespace

CameraServer::CameraServer(const vision::RtpStream& stream, cv::Size size, double rate_hz, bool colour)
    : stream_(stream), thread_([=, this] { Work(size, rate_hz, colour); }) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stage_ != Stage::kOpening; });
  if (stage_ == Stage::kOpen) return;
  lock.unlock();
  thread_.join();
  throw std::runtime_error(fmt::format(
      "{}: cannot be sent; are gstreamer1.0-plugins-base and gstreamer1.0-plugins-good installed?",
      vision::ToText(stream)));
}

CameraServer::~CameraServer() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CameraServer::Publish(const cv::Mat& image) {
  cv::Mat copy = image.clone();
  {
    const std::lock_guard lock(mutex_);
    if (!waiting_.empty()) ++overwritten_;
    std::swap(waiting_, copy);
  }
  changed_.notify_all();
}

std::int64_t CameraServer::sent() const {
  const std::lock_guard lock(mutex_);
  return sent_;
}

std::int64_t CameraServer::overwritten() const {
  const std::lock_guard lock(mutex_);
  return overwritten_;
}

void CameraServer::Work(cv::Size size, double rate_hz, bool colour) {
  cv::VideoWriter writer;
  const bool open = writer.open(SendingPipeline(stream_), cv::CAP_GSTREAMER, 0, rate_hz, size, colour);
  std::unique_lock lock(mutex_);
  stage_ = open ? Stage::kOpen : Stage::kRefused;
  changed_.notify_all();
  while (open) {
    changed_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    const cv::Mat image = std::exchange(waiting_, cv::Mat());
    lock.unlock();
    writer.write(image);
    lock.lock();
    ++sent_;
  }
}

}  // namespace kestrel::sim
