// SPDX-License-Identifier: Apache-2.0
// Landings on decks that move, and landings that are broken off, on seeds that no tuning was done on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>

#include "flight/simulated/runner.h"
#include "tests/acceptance/flown.h"

namespace kestrel {
namespace {

double HeightOverPad(const Truth& t) { return -(t.X_NT.Inverse() * t.X_NB).p.z(); }

std::set<std::string_view> PhasesOf(const flight::FlightResult& result, double from_s, double until_s) {
  std::set<std::string_view> phases;
  for (const records::LogRow& row : result.rows)
    if (row.now.t_s >= from_s && row.now.t_s < until_s) phases.insert(row.decision.phase);
  return phases;
}

TEST(LandingDeck, ComesUpWithACarAtFourMetresASecondAndLandsOnItsMiddle) {
  const flight::FlightResult result = Flown("landing_deck_nested", 101);
  ExpectCriteria(result);
  EXPECT_EQ(result.summary.outcome, "landed");
  EXPECT_NEAR(result.rows.back().now.v_N.norm(), 4, 0.05);  // it rides along
}

TEST(LandingDeck, LandsOnAShipInSeaStateFour) {
  const flight::FlightResult result = Flown("landing_ship_nested", 101);
  ExpectCriteria(result);
  EXPECT_GT(result.summary.metrics.at("deck_max_tilt_deg"), 1);
  EXPECT_LT(result.summary.metrics.at("rest_tilt_deg"), 2);
}

// A sheet is drawn over the pad when the aircraft is 1 m above it, and stays for 3 s.
TEST(LandingDeck, LostAtOneMetreItGoesAroundWithTheDeckAndLandsAtItsNextTry) {
  std::optional<double> at_one_m;
  for (const records::LogRow& row : Flown("landing_deck_nested", 102).rows)
    if (!at_one_m && HeightOverPad(row.now) < 1) at_one_m = row.now.t_s;
  ASSERT_TRUE(at_one_m);
  const std::string until = std::to_string(*at_one_m + 3), from = std::to_string(*at_one_m);
  const flight::FlightResult result = Flown(
      "landing_deck_nested", 102, {"occlusion={share: 1, from_s: " + from + ", until_s: " + until + "}"});
  EXPECT_TRUE(PhasesOf(result, *at_one_m, *at_one_m + 3).contains("go around"));
  for (const records::LogRow& row : result.rows) {
    if (row.now.t_s > *at_one_m && row.now.t_s < *at_one_m + 3) {
      EXPECT_FALSE(row.now.touching);
    }
  }
  EXPECT_EQ(result.summary.outcome, "landed");
  EXPECT_EQ(result.summary.metrics.at("landed_on_deck"), 1);
  EXPECT_GE(result.summary.metrics.at("approaches"), 2);
}

TEST(Landing, InTwelveMetresASecondOfWindItAbortsWithoutATouch) {
  const flight::FlightResult result =
      Flown("landing", 101, {"wind.mean_m_s=12", "criteria={within_limits_or_aborted: {min: 1}}"});
  ExpectCriteria(result);
  EXPECT_EQ(result.summary.outcome, "aborted");
  EXPECT_EQ(result.summary.metrics.at("approaches"), 3);
  for (const records::LogRow& row : result.rows) EXPECT_FALSE(row.now.touching);
}

}  // namespace
}  // namespace kestrel
