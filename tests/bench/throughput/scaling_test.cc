// SPDX-License-Identifier: Apache-2.0
#include "bench/throughput/scaling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kestrel::bench {
namespace {

using testing::ElementsAre;

TEST(Scaling, IsAgainstOneWorkerAndForEachOfThem) {
  const std::vector<Scaling> scaling = ScalingOf({{1, 200}, {2, 380}, {3, 390}});
  ASSERT_EQ(scaling.size(), 3u);
  EXPECT_DOUBLE_EQ(scaling[0].times_one, 1);
  EXPECT_DOUBLE_EQ(scaling[0].efficiency, 1);
  EXPECT_DOUBLE_EQ(scaling[1].times_one, 1.9);
  EXPECT_DOUBLE_EQ(scaling[1].efficiency, 0.95);
  EXPECT_DOUBLE_EQ(scaling[2].efficiency, 0.65);
}

TEST(Scaling, IsTriedToOneWorkerBeyondTheCores) {
  EXPECT_THAT(WorkerCounts(1), ElementsAre(1, 2));
  EXPECT_THAT(WorkerCounts(2), ElementsAre(1, 2, 3));
  EXPECT_THAT(WorkerCounts(8), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(WorkerCounts(16), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 17));
  EXPECT_THAT(WorkerCounts(40), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32, 40, 41));
}

}  // namespace
}  // namespace kestrel::bench
