// SPDX-License-Identifier: Apache-2.0
#include "bench/throughput/scaling.h"

#include <algorithm>

namespace kestrel::bench {

std::vector<Scaling> ScalingOf(const std::vector<WorkersRate>& rates) {
  std::vector<Scaling> scaling;
  for (const WorkersRate& each : rates) {
    const double times = each.rate / rates.front().rate;
    scaling.push_back({times, times / each.workers});
  }
  return scaling;
}

std::vector<int> WorkerCounts(int cores) {
  std::vector<int> counts;
  for (int n = 1; n <= std::min(cores, 8); ++n) counts.push_back(n);
  for (int n = 8; n < cores; n *= 2)
    for (const int each : {n + n / 2, 2 * n})
      if (each < cores) counts.push_back(each);
  if (counts.back() != cores) counts.push_back(cores);
  counts.push_back(cores + 1);
  return counts;
}

}  // namespace kestrel::bench
