// SPDX-License-Identifier: Apache-2.0
// The thesis' helicopter in the multirotor's flights, by the multirotor's own criteria, on seeds that no
// tuning was done on.
#include <gtest/gtest.h>

#include "tests/acceptance/flown.h"

namespace kestrel {
namespace {

TEST(Helicopter, HoversOverThePad) {
  const flight::FlightResult result = Flown("hover", 101, {"vehicle=sr20", "duration_s=30"});
  ExpectCriteria(result);
  for (const records::LogRow& row : result.rows)
    EXPECT_FALSE(row.now.touching || row.estimate.landed) << row.now.t_s;
}

TEST(Helicopter, LandsOnThePadAndStopsItsRotorOnItsSkids) {
  const flight::FlightResult result = Flown("landing", 101, {"vehicle=sr20"});
  EXPECT_EQ(result.summary.outcome, "landed");
  ExpectCriteria(result);
  bool touched = false;
  for (const records::LogRow& row : result.rows) {
    touched = touched || row.now.touching;
    EXPECT_TRUE(touched || !row.estimate.landed) << row.now.t_s;
  }
  EXPECT_LT(result.rows.back().now.v_N.norm(), 0.1);
}

}  // namespace
}  // namespace kestrel
