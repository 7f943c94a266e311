// SPDX-License-Identifier: Apache-2.0
#include "records/plot/plot_rows.h"

#include <gtest/gtest.h>

namespace kestrel::records {
namespace {

TEST(PlotRows, OfAShortFlightAllAreKept) {
  PlotRows kept;
  LogRow row;
  for (; row.sequence < static_cast<std::int64_t>(PlotRows::kMax); ++row.sequence) kept.Add(row);
  ASSERT_EQ(kept.rows().size(), PlotRows::kMax);
  EXPECT_EQ(kept.rows().back().sequence, row.sequence - 1);
}

TEST(PlotRows, OfALongFlightTheyAreEvenlyFewerAndNeverMore) {
  PlotRows kept;
  LogRow row;
  const auto count = static_cast<std::int64_t>(5 * PlotRows::kMax);
  for (; row.sequence < count; ++row.sequence) {
    kept.Add(row);
    ASSERT_LE(kept.rows().size(), PlotRows::kMax);
  }
  ASSERT_GE(kept.rows().size(), PlotRows::kMax / 2);
  const std::int64_t step = kept.rows()[1].sequence;
  for (std::size_t i = 0; i < kept.rows().size(); ++i)
    ASSERT_EQ(kept.rows()[i].sequence, step * static_cast<std::int64_t>(i));
  EXPECT_GT(kept.rows().back().sequence + step, count - 1);  // to the end
}

}  // namespace
}  // namespace kestrel::records
