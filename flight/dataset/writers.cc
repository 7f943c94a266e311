// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/writers.h"

#include <utility>

namespace kestrel::flight {

Writers::Writers(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

Writers::~Writers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Writers::Do(std::function<void()> piece) {
  if (threads_.empty()) return piece();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return failure_ || waiting_.size() < 2 * threads_.size(); });
  if (failure_) std::rethrow_exception(failure_);
  waiting_.push_back(std::move(piece));
  changed_.notify_all();
}

void Writers::Finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return failure_ || (waiting_.empty() && under_way_ == 0); });
  if (failure_) std::rethrow_exception(failure_);
}

void Writers::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || failure_ || !waiting_.empty(); });
    if (stop_ || failure_) return;
    const std::function<void()> piece = std::move(waiting_.front());
    waiting_.pop_front();
    ++under_way_;
    lock.unlock();
    std::exception_ptr thrown;
    try {
      piece();
    } catch (...) {
      thrown = std::current_exception();
    }
    lock.lock();
    --under_way_;
    if (thrown && !failure_) failure_ = thrown;
    changed_.notify_all();
  }
}

}  // namespace kestrel::flight
