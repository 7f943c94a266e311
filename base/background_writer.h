// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace kestrel {

// Does what takes long, in its order, on a thread of its own. Who hands it over never waits: when too much is
// left to do, it is dropped and counted. The first job that throws is the last: what it said is the error.
class BackgroundWriter {
 public:
  explicit BackgroundWriter(std::size_t max_waiting = 64);
  ~BackgroundWriter();  // does what is left

  bool Do(std::function<void()> job);  // false: dropped
  void Finish();                       // waits until all is done; nothing is taken afterwards
  std::int64_t dropped() const;
  std::string error() const;

 private:
  void Work();

  std::size_t max_waiting_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> waiting_;
  bool finished_ = false;
  std::int64_t dropped_ = 0;
  std::string error_;
  std::thread thread_;
};

}  // namespace kestrel
