// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>

namespace kestrel::sim {

// Loops whose rounds are shared by the thread that runs them and one that waits for what they make, so that no
// core is idle meanwhile. Who does which round is left to chance: a round must not depend on another.
class SharedLoop {
 public:
  // Calls round(0) to round(count - 1), each once, on so many threads and those that help, and returns when all of
  // them have returned.
  void Run(int threads, int count, const std::function<void(int)>& round);
  // Takes part in the loops that run, and sleeps between them, until `done`. That is asked anew after Wake().
  void HelpUntil(const std::function<bool()>& done);
  void Wake();

 private:
  void TakePart(const std::function<void(int)>& round, int count);

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void(int)>* round_ = nullptr;  // of the loop that runs
  int count_ = 0, helping_ = 0;
  std::atomic<int> next_ = 0;
};

}  // namespace kestrel::sim
