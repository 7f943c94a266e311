// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/run_result.h"

namespace kestrel::campaign {

// A flight that a worker is to fly.
struct RunOrder {
  std::int64_t row = 0;
  std::string scenario;                         // a name or a file
  std::vector<std::string> overrides;           // "key=value"
  std::optional<std::filesystem::path> folder;  // of its records; none: nothing is written
  bool video = false;
};

// The command of `kestrel-worker`, which is beside this program and of its version, or says that it is not.
// It is the same file as long as this process lives.
std::vector<std::string> WorkerCommand();

// Worker processes that fly. They end with this process, whatever its end. A worker that takes too long is
// ended, and its run comes back as that. One that dies is replaced, and its run is flown again: what a row
// alone does it does again, so a run that its worker dies of twice has crashed, and one whose worker was
// ended from without has not, unless that goes on. To be used by one thread.
class WorkerPool {
 public:
  // limit_s: of wall time for a run. logs: folder for what the workers say, made if need be. command: of a
  // worker, without a shell. Throws std::runtime_error.
  WorkerPool(int workers, double limit_s, const std::filesystem::path& logs,
             const std::vector<std::string>& command = WorkerCommand());
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  bool Idle() const;                 // a worker waits for an order
  void Give(const RunOrder& order);  // to an idle one
  std::size_t under_way() const;     // runs given and not taken
  // The next run that ends; none: none has within this time, or a signal came. Throws std::runtime_error:
  // workers cannot be started.
  std::optional<RunResult> WaitForResult(double max_s);

 private:
  struct Workers;
  std::unique_ptr<Workers> workers_;
};

}  // namespace kestrel::campaign
