// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>
#include <time.h>

#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <thread>

#include "geometry/pose.h"
#include "sim/render/rendering.h"

namespace kestrel::bench {

// A thread that does as it is told: OpenGL's context belongs to one, and each who draws has its own.
class Hand {
 public:
  Hand() : thread_([this] { Work(); }) {}
  ~Hand() {
    Give({});
    thread_.join();
  }
  template <class Function>
  auto Do(Function function) {
    std::packaged_task<decltype(function())()> task(std::move(function));
    auto result = task.get_future();
    Give([&] { task(); });
    return result.get();
  }

 private:
  void Give(std::function<void()> task) {
    {
      const std::lock_guard lock(mutex_);
      task_ = std::move(task);
      given_ = true;
    }
    wake_.notify_one();
  }
  void Work() {
    for (;;) {
      std::function<void()> task;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [&] { return given_; });
        task = std::move(task_);
        given_ = false;
      }
      if (!task) return;
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::function<void()> task_;
  bool given_ = false;
  std::thread thread_;
};

// One who draws, on a thread of its own.
template <class Drawing>
class Drawer {
 public:
  template <class... Arguments>
  explicit Drawer(const Arguments&... arguments) {
    hand_.Do([&] { drawing_ = std::make_unique<Drawing>(arguments...); });
  }
  ~Drawer() {
    hand_.Do([&] { drawing_.reset(); });
  }
  cv::Mat Render(const mjData* data, const Pose& X_NC) {
    return hand_.Do([&] { return drawing_->Render(data, X_NC); });
  }
  sim::Surfaces Trace(const mjData* data, const Pose& X_NC) {
    return hand_.Do([&] { return drawing_->Trace(data, X_NC); });
  }
  const Drawing& drawing() const { return *drawing_; }
  // Milliseconds of processor time, of all threads together.
  double Time(const mjData* data, const Pose& X_NC) {
    const auto now_ms = [] {
      timespec t;
      clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
      return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
    };
    const double start = now_ms();
    Render(data, X_NC);
    return now_ms() - start;
  }

 private:
  Hand hand_;
  std::unique_ptr<Drawing> drawing_;
};

}  // namespace kestrel::bench
