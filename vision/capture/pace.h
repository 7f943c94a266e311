// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

namespace kestrel::vision {

// Lets a recording come as slowly as a camera.
class Pace {
 public:
  explicit Pace(double rate_hz) : rate_hz_(rate_hz) {}  // 0: at once

  void Wait() {
    if (rate_hz_ <= 0) return;
    std::this_thread::sleep_until(due_);
    due_ = std::max(due_, Clock::now()) +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_hz_));
  }

 private:
  using Clock = std::chrono::steady_clock;
  double rate_hz_;
  Clock::time_point due_{};
};

}  // namespace kestrel::vision
