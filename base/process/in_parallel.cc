// SPDX-License-Identifier: Apache-2.0
#include "base/process/in_parallel.h"

#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "base/process/status_line.h"

namespace kestrel {

void InParallel(std::size_t count, int jobs, const std::string& title, const std::string& unit,
                const std::function<void(std::size_t)>& piece) {
  StatusLine line(title);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;  // of the two below, and of the line
  std::exception_ptr failure;
  std::size_t done = 0;
  const auto work = [&] {
    for (std::size_t i; !failed && (i = next++) < count;) {
      try {
        piece(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        failed = true;
      }
      const std::lock_guard lock(mutex);
      ++done;
      line.Show(fmt::format("{} of {} {}", done, count, unit));
    }
  };
  std::vector<std::thread> workers;
  for (int w = 0; w < jobs; ++w) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  line.Clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace kestrel
