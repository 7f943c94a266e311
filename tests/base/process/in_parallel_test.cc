// SPDX-License-Identifier: Apache-2.0
#include "base/process/in_parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace kestrel {
namespace {

TEST(InParallel, EveryPieceIsDoneOnce) {
  std::vector<int> times(1000, 0);
  InParallel(times.size(), 4, "", "", [&](std::size_t i) { ++times[i]; });
  EXPECT_EQ(times, std::vector<int>(1000, 1));
}

TEST(InParallel, ThrowsWhatAPieceThrewAndBeginsNoFurtherOnes) {
  std::atomic<int> begun = 0;
  const auto piece = [&](std::size_t i) {
    ++begun;
    if (i == 3) throw std::invalid_argument("three");
  };
  EXPECT_THROW(InParallel(1000000, 1, "", "", piece), std::invalid_argument);
  EXPECT_EQ(begun, 4);
}

}  // namespace
}  // namespace kestrel
