// SPDX-License-Identifier: Apache-2.0
#include "base/background_writer.h"

#include <exception>
#include <utility>

namespace kestrel {

BackgroundWriter::BackgroundWriter(std::size_t max_waiting)
    : max_waiting_(max_waiting), thread_([this] { Work(); }) {}

BackgroundWriter::~BackgroundWriter() { Finish(); }

bool BackgroundWriter::Do(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    if (finished_ || !error_.empty() || waiting_.size() >= max_waiting_) {
      ++dropped_;
      return false;
    }
    waiting_.push_back(std::move(job));
  }
  wake_.notify_one();
  return true;
}

void BackgroundWriter::Finish() {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

std::int64_t BackgroundWriter::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

std::string BackgroundWriter::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void BackgroundWriter::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return finished_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const std::function<void()> job = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    std::string error;
    try {
      job();
    } catch (const std::exception& e) {
      error = e.what();
    }
    lock.lock();
    if (error.empty()) continue;
    error_ = error;
    dropped_ += static_cast<std::int64_t>(waiting_.size());
    waiting_.clear();
  }
}

}  // namespace kestrel
