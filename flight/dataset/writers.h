// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kestrel::flight {

// Threads that write while a flight goes on. Who hands a piece over waits while too many are left to do.
class Writers {
 public:
  explicit Writers(int threads);  // 0: pieces are done by who hands them over
  ~Writers();                     // leaves what is not begun
  Writers(const Writers&) = delete;
  Writers& operator=(const Writers&) = delete;

  // Throws what an earlier piece threw.
  void Do(std::function<void()> piece);
  void Finish();  // waits until all is done; throws what a piece threw

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  std::size_t under_way_ = 0;
  bool stop_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace kestrel::flight
