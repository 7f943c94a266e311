// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/view/view_video.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kestrel::flight {
namespace {

constexpr int kMost_kbit_s = 400;        // it has no noise of a camera
constexpr std::size_t kMostWaiting = 8;  // pictures, before the flight waits

// The image in the lower right corner, a third as wide, in a thin frame.
void PutInCorner(const cv::Mat& image, cv::Mat& picture) {
  constexpr double kWidth = 1.0 / 3, kHighest = 0.45;
  const double scale = std::min(kWidth * picture.cols / image.cols, kHighest * picture.rows / image.rows);
  const cv::Size size(std::max(1, static_cast<int>(scale * image.cols)),
                      std::max(1, static_cast<int>(scale * image.rows)));
  const int margin = picture.cols / 60, frame = std::max(1, picture.cols / 480);
  cv::Mat small, colour = image;
  if (image.channels() == 1) cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  cv::resize(colour, small, size, 0, 0, cv::INTER_AREA);
  const cv::Rect place(picture.cols - size.width - margin, picture.rows - size.height - margin, size.width,
                       size.height);
  const cv::Rect whole =
      cv::Rect(place.x - frame, place.y - frame, place.width + 2 * frame, place.height + 2 * frame) &
      cv::Rect({}, picture.size());
  picture(whole).setTo(cv::Scalar::all(255));
  small.copyTo(picture(place));
}

}  // namespace

ViewVideo::ViewVideo(const sim::Simulator& simulator, ViewOptions options,
                     const std::optional<std::filesystem::path>& file, double rate_hz, int threads)
    : options_(std::move(options)),
      camera_(simulator.model(), options_.parameters),
      renderer_(simulator.model(), options_.parameters, threads) {
  if (file && options_.video) video_.emplace(*file, rate_hz, kMost_kbit_s);
  thread_ = std::thread([this] { Work(); });
}

ViewVideo::~ViewVideo() { End(); }

void ViewVideo::Write(const sim::Simulator& simulator, const cv::Mat& camera) {
  Job job{simulator.snapshot(), camera_.At(simulator.truth()), options_.with_camera ? camera : cv::Mat()};
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return jobs_.size() < kMostWaiting || error_; });
  if (error_) std::rethrow_exception(error_);
  jobs_.push_back(std::move(job));
  wake_.notify_all();
}

void ViewVideo::Work() {
  while (true) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return !jobs_.empty() || ended_; });
    if (jobs_.empty()) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    wake_.notify_all();
    lock.unlock();
    try {
      cv::Mat picture = renderer_.Draw(job.world, job.aim);
      if (!job.camera.empty()) PutInCorner(job.camera, picture);
      if (video_) video_->Write(picture);
      if (options_.on_frame) options_.on_frame(job.world.t_s, picture);
    } catch (...) {
      lock.lock();
      error_ = std::current_exception();
      jobs_.clear();
      wake_.notify_all();
      return;
    }
  }
}

void ViewVideo::End() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    wake_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void ViewVideo::Close() {
  End();
  if (error_) std::rethrow_exception(error_);
  if (video_) video_->Close();
}

}  // namespace kestrel::flight
