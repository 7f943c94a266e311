// SPDX-License-Identifier: Apache-2.0
#include "base/process/in_parallel.h"

#include <unistd.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "base/process/print_note.h"

namespace kestrel {

void InParallel(std::size_t count, int jobs, const std::string& title, const std::string& unit,
                const std::function<void(std::size_t)>& piece) {
  const bool terminal = isatty(STDERR_FILENO);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;  // of the two below, and of the terminal's line
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
      if (terminal) PrintNote("\r\033[K{}: {} of {} {}", title, done, count, unit);
    }
  };
  std::vector<std::thread> workers;
  for (int w = 0; w < jobs; ++w) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  if (terminal) PrintNote("\r\033[K");
  if (failure) std::rethrow_exception(failure);
}

}  // namespace kestrel
