// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/block_count.h"

#include <gtest/gtest.h>

#include <vector>

namespace kestrel::vision {
namespace {

std::vector<std::int64_t> Steps(const std::vector<std::uint64_t>& ids) {
  BlockCount count;
  std::vector<std::int64_t> steps;
  std::int64_t last = count.Of(ids[0]);
  for (std::size_t i = 1; i < ids.size(); ++i) {
    const std::int64_t now = count.Of(ids[i]);
    steps.push_back(now - last);
    last = now;
  }
  return steps;
}

using Expected = std::vector<std::int64_t>;

TEST(BlockCount, GoesOnWhereIdsOfSixteenBitsBeginAgainAtOne) {
  EXPECT_EQ(Steps({65533, 65534, 65535, 1, 2, 5}), (Expected{1, 1, 1, 1, 3}));
}

TEST(BlockCount, ALateBlockCountsBackwardAlsoOverTheEnd) {
  EXPECT_EQ(Steps({10, 12, 11, 13}), (Expected{2, -1, 2}));
  EXPECT_EQ(Steps({65535, 2, 1, 3}), (Expected{2, -1, 2}));
  EXPECT_EQ(Steps({65534, 1, 65535, 2}), (Expected{2, -1, 2}));
}

TEST(BlockCount, IdsOfSixtyFourBitsDoNotBeginAgain) {
  EXPECT_EQ(Steps({65534, 65535, 65536, 65537, 200000}), (Expected{1, 1, 1, 134463}));
}

}  // namespace
}  // namespace kestrel::vision
