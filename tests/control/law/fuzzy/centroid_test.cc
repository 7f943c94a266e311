// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/centroid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace kestrel::control {
namespace {

constexpr Aggregation kBoth[] = {Aggregation::kMax, Aggregation::kSum};

TEST(FuzzySet, IsATrapezoidBetweenItsCorners) {
  const FuzzySet set{{1, 2, 4, 8}};
  const double table[][2] = {{0.9, 0}, {1, 0}, {1.5, 0.5}, {2, 1}, {3, 1}, {4, 1}, {5, 0.75}, {8, 0}, {9, 0}};
  for (const auto& [x, membership] : table) EXPECT_EQ(Membership(set, x), membership) << x;
  EXPECT_EQ(Membership(set, NAN), 0);
}

TEST(FuzzySet, AShoulderHoldsAtItsEnd) {
  EXPECT_EQ(Membership({{0, 0, 1, 2}}, 0), 1);
  EXPECT_EQ(Membership({{0, 0, 1, 2}}, -1e-9), 0);
  EXPECT_EQ(Membership({{0, 1, 2, 2}}, 2), 1);
}

// By hand, from rectangles and triangles.
TEST(Centroid, OfOneSetIsThatOfItsShape) {
  const FuzzySet even{{0, 1, 1, 2}}, right{{0, 0, 0, 3}};
  for (const Aggregation aggregation : kBoth) {
    EXPECT_DOUBLE_EQ(*Centroid({Scaled(even, 0.3)}, aggregation, -5, 5), 1);
    EXPECT_DOUBLE_EQ(*Centroid({CutOff(even, 0.3)}, aggregation, -5, 5), 1);
    EXPECT_DOUBLE_EQ(*Centroid({Scaled(right, 0.5)}, aggregation, 0, 3), 1);
    EXPECT_DOUBLE_EQ(*Centroid({CutOff(right, 0.5)}, aggregation, 0, 3), 7.0 / 6);
    EXPECT_DOUBLE_EQ(*Centroid({Scaled(even, 1)}, aggregation, 1, 5), 4.0 / 3);  // its right half
  }
}

TEST(Centroid, OfTwoSetsThatOverlapDependsOnHowTheyAreJoined) {
  const std::vector<ImpliedSet> sets = {Scaled({{0, 1, 1, 2}}, 1), Scaled({{1, 2, 2, 3}}, 0.5)};
  EXPECT_DOUBLE_EQ(*Centroid(sets, Aggregation::kSum, 0, 3), 4.0 / 3);
  EXPECT_DOUBLE_EQ(*Centroid(sets, Aggregation::kMax, 0, 3), 47.0 / 36);
}

TEST(Centroid, ThereIsNoneWithoutArea) {
  for (const Aggregation aggregation : kBoth) {
    EXPECT_FALSE(Centroid({}, aggregation, 0, 1));
    EXPECT_FALSE(Centroid({Scaled({{0, 1, 1, 2}}, 0)}, aggregation, 0, 1));
    EXPECT_FALSE(Centroid({Scaled({{2, 3, 3, 4}}, 1)}, aggregation, 0, 1));
  }
}

// By the definition of the integrals, at the middles of many intervals.
TEST(Centroid, OfManySetsIsTheQuotientOfItsIntegrals) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-1, 2), share(0, 1);
  int cases = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<ImpliedSet> sets;
    for (int k = 0; k < 1 + trial % 6; ++k) {
      Eigen::Vector4d corners(at(random), at(random), at(random), at(random));
      std::sort(corners.begin(), corners.end());
      if (k % 3 == 1) corners[1] = corners[0];  // leaps
      sets.push_back(trial % 2 ? CutOff({corners}, share(random)) : Scaled({corners}, share(random)));
    }
    for (const Aggregation aggregation : kBoth) {
      constexpr int kIntervals = 20000;
      double area = 0, first = 0;
      for (int i = 0; i < kIntervals; ++i) {
        const double x = (i + 0.5) / kIntervals;
        double y = 0;
        for (const ImpliedSet& set : sets) {
          const double own = set.height * Membership({set.corners}, x);
          y = aggregation == Aggregation::kMax ? std::max(y, own) : y + own;
        }
        area += y, first += x * y;
      }
      if (area < 0.01 * kIntervals) continue;
      // A leap within an interval counts as the whole of it or nothing.
      const double tolerance = static_cast<double>(sets.size()) / area;
      EXPECT_NEAR(Centroid(sets, aggregation, 0, 1).value(), first / area, tolerance) << trial;
      ++cases;
    }
  }
  EXPECT_GT(cases, 25);
}

}  // namespace
}  // namespace kestrel::control
