// SPDX-License-Identifier: Apache-2.0
#include "base/nearest_name.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(NearestName, ALetterThatIsWrongMissingOrOneTooMuchAndTwoThatChangedPlaces) {
  const std::vector<std::string> verbs = {"run", "list", "man", "serve", "campaign"};
  for (const auto& [written, meant] : {std::pair{"rn", "run"},
                                       {"rnu", "run"},
                                       {"runn", "run"},
                                       {"rum", "run"},
                                       {"lits", "list"},
                                       {"sreve", "serve"}})
    EXPECT_EQ(NearestName(written, verbs), meant) << written;
}

TEST(NearestName, ANameThatWasCutShort) {
  EXPECT_EQ(NearestName("duraton", {"duration_s", "rate_hz"}), "duration_s");
  EXPECT_EQ(NearestName("mean", {"mean_m_s", "from_deg"}), "mean_m_s");
  EXPECT_EQ(NearestName("wind.mean", {"wind.from_deg", "wind.mean_m_s"}), "wind.mean_m_s");
}

TEST(NearestName, TheWholeNameIsNearerThanTheBeginningOfALongerOne) {
  EXPECT_EQ(NearestName("landinf", {"landing_faint", "landing"}), "landing");
}

TEST(NearestName, WhatHasLittleInCommonIsNoGuess) {
  EXPECT_EQ(NearestName("land", {"man", "list", "run"}), std::nullopt);
  EXPECT_EQ(NearestName("x", {"y_m", "seed"}), std::nullopt);
  EXPECT_EQ(NearestName("", {"seed"}), std::nullopt);
}

TEST(NearestName, TheRemedyIsTheNearestOrAll) {
  EXPECT_EQ(RemedyForName("sed", {"seed", "name"}), "did you mean 'seed'?");
  EXPECT_EQ(RemedyForName("colour", {"seed", "name"}), "valid: seed, name");
}

}  // namespace
}  // namespace kestrel
