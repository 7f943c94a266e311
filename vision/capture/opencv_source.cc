// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/opencv_source.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "base/stopwatch.h"
#include "vision/capture/gstreamer_pipeline.h"
#include "vision/capture/pace.h"
#include "vision/capture/udp_claim.h"

namespace kestrel::vision {
namespace {

using Kind = OpenCvSourceOptions::Kind;

std::string PipelineWithSink(const std::string& what) {
  return what.find("appsink") != std::string::npos ? what
                                                   : what + " ! appsink drop=true max-buffers=1 sync=false";
}

class OpenCvReader final : public ImageSource {
 public:
  // claim: of the port where it listens; null: nowhere.
  OpenCvReader(const OpenCvSourceOptions& options, std::shared_ptr<UdpClaim> claim)
      : claim_(std::move(claim)), options_(options), pace_(options.rate_hz) {}

  bool Open() override {
    if (claim_) {
      if (error_ = claim_->Take(); !error_.empty()) return false;
    }
    if (OpenKind()) return true;
    error_ = options_.what + " cannot be opened";
    if (!pipeline_.Error().empty()) error_ += ": " + pipeline_.Error();
    return false;
  }

  std::optional<Grabbed> Grab() override {
    if (options_.kind == Kind::kFile) pace_.Wait();
    cv::Mat raw;
    double grabbed_s = 0;
    if (options_.kind == Kind::kGStreamer) {
      raw = pipeline_.Next();
      grabbed_s = MonotonicNow_s();
      if (raw.empty())
        error_ = fmt::format("no more images come from {}: {}", options_.what, pipeline_.Error());
    } else if (capture_.grab()) {
      grabbed_s = MonotonicNow_s();
      capture_.retrieve(raw);
    } else if (!Ended()) {
      error_ = "no more images come from " + options_.what;
    }
    if (raw.empty()) return std::nullopt;
    if (!options_.size.empty() && raw.size() != options_.size) {
      error_ = fmt::format("an image of {}x{} came, not of {}x{}", raw.cols, raw.rows, options_.size.width,
                           options_.size.height);
      return std::nullopt;
    }
    Grabbed grabbed;
    const int channels = options_.colour ? 3 : 1;
    if (raw.depth() != CV_8U || (raw.channels() != 1 && raw.channels() != 3)) {
      error_ = fmt::format("an image of {} channels came, of depth {}", raw.channels(), raw.depth());
      return std::nullopt;
    }
    if (raw.channels() == channels)
      grabbed.image =
          options_.kind == Kind::kGStreamer ? raw : raw.clone();  // a driver's buffer comes round again
    else
      cv::cvtColor(raw, grabbed.image, options_.colour ? cv::COLOR_GRAY2BGR : cv::COLOR_BGR2GRAY);
    if (options_.kind == Kind::kV4l2) {
      const double stamp_s = capture_.get(cv::CAP_PROP_POS_MSEC) / 1000;
      if (stamp_s > 0) grabbed.stamp_s = stamp_s;
    } else {
      grabbed.stamp_s = grabbed_s;
    }
    return grabbed;
  }

  bool Ended() const override { return options_.kind == Kind::kFile; }
  std::string Error() const override { return error_; }

 private:
  bool OpenKind() {
    switch (options_.kind) {
      case Kind::kV4l2:
        // Two buffers: one is filled while the other is read; more would be older images.
        return capture_.open(options_.what, cv::CAP_V4L2, Wanted({cv::CAP_PROP_BUFFERSIZE, 2}));
      case Kind::kGStreamer:
        return pipeline_.Open(PipelineWithSink(options_.what), options_.payloads);
      case Kind::kIeee1394:
        return capture_.open(std::stoi(options_.what), cv::CAP_FIREWIRE, Wanted({}));
      case Kind::kFile:
        return capture_.open(options_.what, cv::CAP_FFMPEG);
    }
    return false;
  }

  std::vector<int> Wanted(std::vector<int> properties) const {
    if (!options_.size.empty())
      properties.insert(properties.end(), {cv::CAP_PROP_FRAME_WIDTH, options_.size.width,
                                           cv::CAP_PROP_FRAME_HEIGHT, options_.size.height});
    if (options_.rate_hz > 0)
      properties.insert(properties.end(),
                        {cv::CAP_PROP_FPS, static_cast<int>(std::lround(options_.rate_hz))});
    return properties;
  }

  std::shared_ptr<UdpClaim> claim_;
  OpenCvSourceOptions options_;
  cv::VideoCapture capture_;
  GStreamerPipeline pipeline_;  // not OpenCV's, whose bus nobody reads
  Pace pace_;
  std::string error_;
};

}  // namespace

ImageSourceMaker OpenCvSource(const OpenCvSourceOptions& options) {
  // One for all that are made, since one that hangs goes on listening.
  std::shared_ptr<UdpClaim> claim;
  if (options.port != 0)
    claim = std::make_shared<UdpClaim>(options.host, static_cast<std::uint16_t>(options.port));
  return [options, claim] { return std::make_unique<OpenCvReader>(options, claim); };
}

}  // namespace kestrel::vision
