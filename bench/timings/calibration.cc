// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/calibration.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "base/random.h"

namespace kestrel::bench {
namespace {

// What is stored here, no compiler leaves out.
volatile double kept = 0;

}  // namespace

Block ArithmeticLoop() {
  return [] {
    const WorkClock clock;
    constexpr int kSteps = 2'000'000;
    double a = 0.5, b = 0.25;
    for (int i = 0; i < kSteps; ++i) {
      a = 3.7 * a * (1 - a);  // stays within (0, 1), and no compiler knows where
      b = 0.5 * (b + a * a);
    }
    kept = a + b;
    return clock.Taken(1);
  };
}

Block MemoryLoop() {
  constexpr std::size_t kNumbers = std::size_t{1} << 23;  // 32 MiB
  auto numbers = std::make_shared<std::vector<std::uint32_t>>(kNumbers);
  std::iota(numbers->begin(), numbers->end(), 0u);
  return [numbers] {
    const WorkClock clock;
    constexpr int kJumps = 400'000;
    std::uint64_t sum = 0, at = 1;
    for (int i = 0; i < kJumps; ++i) {
      at = RandomStream::Mix(at);
      sum += (*numbers)[at % kNumbers];
    }
    sum = std::accumulate(numbers->begin(), numbers->end(), sum);
    kept = static_cast<double>(sum);
    return clock.Taken(1);
  };
}

}  // namespace kestrel::bench
