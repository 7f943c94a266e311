// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace kestrel::bench {

// What so many workers do together.
struct WorkersRate {
  int workers = 1;
  double rate = 0;  // of anything, by time
};

struct Scaling {
  double times_one = 1;   // as fast as one worker
  double efficiency = 1;  // of that, for each worker
};
// Of each; the first is of one worker. A rate of 0 scales to 0.
std::vector<Scaling> ScalingOf(const std::vector<WorkersRate>& rates);

// How many workers to try on so many cores: each number to 8, then every half and whole power of two, the cores, and
// one beyond them.
std::vector<int> WorkerCounts(int cores);

}  // namespace kestrel::bench
