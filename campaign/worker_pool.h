// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "campaign/run_result.h"

namespace kestrel {

// A flight that a worker is to fly.
struct RunOrder {
  std::int64_t row = 0;
  std::string scenario;                         // a name or a file
  std::vector<std::string> overrides;           // "key=value"
  std::optional<std::filesystem::path> folder;  // of its records; none: nothing is written
  bool video = false;
};

// Worker processes that fly: this program itself, started again for each. A worker that crashes or takes too
// long costs the run that it had, which comes back as that, and is replaced. They end with this process,
// whatever its end.
class WorkerPool {
 public:
  // limit_s: of wall time for a run. logs: folder for what the workers say. Throws std::runtime_error.
  WorkerPool(int workers, double limit_s, const std::filesystem::path& logs);
  ~WorkerPool();

  bool Idle() const;                 // a worker waits for an order
  void Give(const RunOrder& order);  // to an idle one
  std::size_t under_way() const;
  // The next run that ends; none: none has within this time.
  std::optional<RunResult> Take(double most_s);

 private:
  struct Workers;
  std::unique_ptr<Workers> workers_;
};

// The other side: flies what comes on standard input until it ends, and answers on what was standard output.
int WorkerMain();

}  // namespace kestrel
