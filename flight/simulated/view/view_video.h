// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <thread>

#include "flight/simulated/view/view_options.h"
#include "records/video/video.h"
#include "sim/simulator.h"
#include "sim/view/view_camera.h"
#include "sim/view/view_renderer.h"

namespace kestrel::flight {

// Draws the view and writes it as a video, beside the flight, on a thread of its own. A flight that is much
// faster waits for it; it is the same with and without.
class ViewVideo {
 public:
  // file: of the video; none: none is written. rate_hz, threads: as in Video and ViewRenderer. Throws
  // std::runtime_error.
  ViewVideo(const sim::Simulator& simulator, ViewOptions options,
            const std::optional<std::filesystem::path>& file, double rate_hz, int threads);
  ~ViewVideo();
  ViewVideo(const ViewVideo&) = delete;
  ViewVideo& operator=(const ViewVideo&) = delete;

  // The next picture: of the simulator's instant. camera: the image on board, for the corner.
  void Write(const sim::Simulator& simulator, const cv::Mat& camera);
  // Waits for what is not yet drawn and ends the file. Throws what drawing or writing has thrown.
  void Close();

 private:
  struct Job {
    sim::Snapshot world;
    sim::ViewAim aim;
    cv::Mat camera;
  };
  void Work();
  void End();

  ViewOptions options_;
  sim::ViewCamera camera_;
  sim::ViewRenderer renderer_;
  std::optional<records::Video> video_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  bool ended_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace kestrel::flight
