// SPDX-License-Identifier: Apache-2.0
#include "sim/render/shared_loop.h"

#include <algorithm>
#include <thread>
#include <vector>

namespace kestrel::sim {

void SharedLoop::TakePart(const std::function<void(int)>& round, int count) {
  for (int i = next_++; i < count; i = next_++) round(i);
}

void SharedLoop::Run(int threads, int count, const std::function<void(int)>& round) {
  {
    const std::lock_guard lock(mutex_);
    next_ = 0;
    count_ = count;
    round_ = &round;
  }
  changed_.notify_all();
  {
    std::vector<std::jthread> others;
    for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back([&] { TakePart(round, count); });
    TakePart(round, count);
  }
  std::unique_lock lock(mutex_);
  round_ = nullptr;  // none joins any more
  changed_.wait(lock, [this] { return helping_ == 0; });
}

void SharedLoop::HelpUntil(const std::function<bool()>& done) {
  std::unique_lock lock(mutex_);
  while (!done()) {
    if (round_ && next_ < count_) {
      ++helping_;
      const auto& round = *round_;
      const int count = count_;
      lock.unlock();
      TakePart(round, count);
      lock.lock();
      if (--helping_ == 0) changed_.notify_all();
    } else {
      changed_.wait(lock);
    }
  }
}

void SharedLoop::Wake() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

}  // namespace kestrel::sim
