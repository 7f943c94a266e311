// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/share_sequence.h"

#include <map>

#include "tests/campaign/statistics/coverage.h"

namespace kestrel::campaign {
namespace {

TEST(ShareSequence, ItsEndsAreWhereTheMixtureIsTwentyTimesAsLikely) {
  for (const auto& [passed, runs] : {std::pair(3, 4), {17, 30}, {99, 100}, {100, 100}, {0, 12}}) {
    // The mixture's likelihood as the product of what it foretells for each run, having seen those before.
    double mixture = 0;
    for (int i = 0; i < runs; ++i) {
      const bool success = i < passed;
      mixture += std::log(((success ? i : i - passed) + 0.5) / (i + 1));
    }
    const auto times = [&, passed = passed, runs = runs](double p) {
      const double likelihood =
          (passed > 0 ? passed * std::log(p) : 0) + (runs > passed ? (runs - passed) * std::log1p(-p) : 0);
      return std::exp(mixture - likelihood);
    };
    const Interval interval = ShareSequence(passed, runs);
    if (passed > 0) {
      EXPECT_NEAR(times(interval.low), 20, 1e-6);
    } else {
      EXPECT_EQ(interval.low, 0);
    }
    if (passed < runs) {
      EXPECT_NEAR(times(interval.high), 20, 1e-6);
    } else {
      EXPECT_EQ(interval.high, 1);
    }
    EXPECT_LT(times((interval.low + interval.high) / 2), 20);
  }
  EXPECT_EQ(ShareSequence(0, 0), (Interval{0, 1}));
}

// Counts come again and again in simulations: each is worked out once.
template <class Function>
auto Remembered(Function function) {
  return [function, known = std::map<std::pair<int, int>, decltype(function(0, 1))>()](int passed,
                                                                                       int runs) mutable {
    const auto found = known.find({passed, runs});
    if (found != known.end()) return found->second;
    return known[{passed, runs}] = function(passed, runs);
  };
}

// A campaign of at most 400 runs that is looked at after every second one, and ends as soon as it shows what
// its owner fears or hopes: that the share is not p.
template <class Rule>
double ErrorOfStoppingWhenItSuits(double p, int simulations, Rule rule) {
  RandomStream random(8, "stopping");
  int wrong = 0;
  for (int i = 0; i < simulations; ++i) {
    int passed = 0;
    for (int n = 1; n <= 400; ++n) {
      passed += random.Uniform(0, 1) < p;
      if (n % 2 != 0 || rule(passed, n).Holds(p)) continue;
      ++wrong;
      break;
    }
  }
  return static_cast<double>(wrong) / simulations;
}

TEST(ShareSequence, KeepsItsLevelHoweverOftenItIsLookedAtAndTheExactIntervalDoesNot) {
  const int simulations = 500;
  for (const double p : {0.6, 0.95}) {
    const auto error = [&](auto rule) {
      return ErrorOfStoppingWhenItSuits(p, simulations, Remembered(rule));
    };
    EXPECT_LE(error([](int k, int n) { return ShareSequence(k, n); }), 0.05 + Chance(simulations));
    EXPECT_GE(error([](int k, int n) { return ShareInterval(k, n); }), 0.12);
  }
}

TEST(ShareSequence, IsRightWhereNarrowEnoughStops) {
  const int simulations = 300;
  auto enough = Remembered([](int k, int n) { return NarrowEnough(k, n, 0.1); });
  for (const double p : {0.5, 0.9, 0.99}) {
    const double coverage = Coverage(simulations, p, [&](RandomStream& random) {
      int passed = 0, n = 0;
      while (!enough(passed, n)) ++n, passed += random.Uniform(0, 1) < p;
      return ShareSequence(passed, n);
    });
    EXPECT_GE(coverage, 0.95 - Chance(simulations)) << p;
  }
}

TEST(ShareSequence, NarrowEnoughIsOfHalfTheWidth) {
  const Interval interval = ShareSequence(95, 100);
  const double half = (interval.high - interval.low) / 2;
  EXPECT_TRUE(NarrowEnough(95, 100, half * 1.001));
  EXPECT_FALSE(NarrowEnough(95, 100, half * 0.999));
  EXPECT_FALSE(NarrowEnough(0, 0, 0.4));
}

}  // namespace
}  // namespace kestrel::campaign
