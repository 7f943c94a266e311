// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/fly_row.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kestrel::campaign {
namespace {

RunResult Fly(const std::string& scenario, std::vector<std::string> overrides) {
  RunOrder order;
  order.scenario = scenario;
  order.overrides = std::move(overrides);
  return FlyRow(order);
}

// What flights of a process have in common is made once: textures, lenses, a painted landscape, features of the pad.
TEST(FlyRow, AFlightIsTheSameFirstAndAfterItselfAndAfterOthers) {
  const auto landing = [] {
    return Fly("landing", {"seed=3", "criteria={}", "duration_s=0.5", "start.height_m=2"});
  };
  const auto attitude = [](const char* world) {
    return Fly("attitude_1", {"seed=3", "criteria={}", "duration_s=0.3", "landscape.seed=7",
                              std::string("world=") + world});
  };
  const RunResult first = landing(), again = landing();
  ASSERT_EQ(first.state_hash.size(), 16u) << first.outcome;
  const RunResult autumn = attitude("autumn_clear");
  ASSERT_EQ(autumn.state_hash.size(), 16u) << autumn.outcome;
  const RunResult autumn_again = attitude("autumn_clear"), winter = attitude("winter_cloudy");
  const RunResult wide = Fly("landing_h", {"seed=3", "criteria={}", "duration_s=0.5"});
  for (const RunResult& later : {again, landing()}) {
    EXPECT_EQ(later.state_hash, first.state_hash);
    EXPECT_EQ(later.image_hash, first.image_hash);
  }
  for (const RunResult& later : {autumn_again, attitude("autumn_clear")}) {
    EXPECT_EQ(later.state_hash, autumn.state_hash);
    EXPECT_EQ(later.image_hash, autumn.image_hash);
  }
  EXPECT_NE(winter.image_hash, autumn.image_hash);
  EXPECT_NE(wide.image_hash, first.image_hash);
}

}  // namespace
}  // namespace kestrel::campaign
