// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/sample_table.h"

#include <gmock/gmock.h>

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;

const SampleTable kTable{{"seed", "wind.mean_m_s"}, {{"7", "1.5"}, {"8", "0"}}};

TEST(SampleTable, ARowIsWhatSetTakes) {
  EXPECT_THAT(OverridesOf(kTable, 0), ElementsAre("seed=7", "wind.mean_m_s=1.5"));
}

TEST(SampleTable, AnotherContentHasAnotherHash) {
  EXPECT_EQ(HashOf(kTable), HashOf(SampleTable(kTable)));
  EXPECT_EQ(HashOf(kTable).size(), 16u);
  SampleTable other = kTable;
  other.rows[1][1] = "0.0";
  EXPECT_NE(HashOf(other), HashOf(kTable));
  other = kTable;
  other.keys[1] = "wind.mean";
  EXPECT_NE(HashOf(other), HashOf(kTable));
  other = kTable;
  std::swap(other.rows[0], other.rows[1]);
  EXPECT_NE(HashOf(other), HashOf(kTable));
  other = {{"seed"}, {{"7"}, {"1.5"}, {"8"}, {"0"}}};  // the same texts in another shape
  EXPECT_NE(HashOf(other), HashOf(kTable));
}

}  // namespace
}  // namespace kestrel::campaign
