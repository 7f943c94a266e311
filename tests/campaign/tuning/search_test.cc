// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/search.h"

#include "campaign/tuning/pagmo_eigen.h"
// before the others

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

namespace kestrel::campaign {
namespace {

using ::testing::Each;
using ::testing::Ge;
using ::testing::Le;

constexpr const char* kMethods[] = {"cma_es", "cross_entropy", "random_search"};

// A long valley across the axes, its floor at (0.7, 0.6, ...).
double Valley(const Point& x) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const double a = x[i] - 0.7 + 0.1 * static_cast<double>(i),
                 b = x[i + 1] - 0.6 + 0.1 * static_cast<double>(i);
    sum += (a + b) * (a + b) + 100 * (a - b) * (a - b);
  }
  return sum;
}

// The least cost that some evaluations find, or that of where they say the least is.
double Least(const std::string& method, int evaluations, std::uint64_t seed,
             const std::function<double(const Point&)>& cost, std::size_t dimension) {
  Search search = MakeSearch(method, Point(dimension, 0.1), seed);
  double least = 1e9;
  for (int used = 0;;) {
    std::vector<double> costs;
    for (const Point& point : std::visit([](auto& s) { return s.Ask(); }, search))
      costs.push_back(cost(point));
    used += static_cast<int>(costs.size());
    if (used > evaluations)
      return std::min(least, cost(std::visit([](auto& s) { return s.Centre(); }, search)));
    least = std::min(least, *std::min_element(costs.begin(), costs.end()));
    std::visit([&](auto& s) { s.Tell(costs); }, search);
  }
}

double MedianLeast(const std::string& method, const std::function<double(const Point&)>& cost,
                   int evaluations = 300) {
  std::vector<double> found;
  for (std::uint64_t seed = 1; seed <= 51; ++seed) found.push_back(Least(method, evaluations, seed, cost, 4));
  std::nth_element(found.begin(), found.begin() + 25, found.end());
  return found[25];
}

TEST(Search, CmaEsFindsTheFloorOfAValleyThatTheOthersDoNot) {
  const double cma_es = MedianLeast("cma_es", Valley);
  EXPECT_LT(cma_es, 0.5 * MedianLeast("cross_entropy", Valley));
  EXPECT_LT(cma_es, 0.2 * MedianLeast("random_search", Valley));
  EXPECT_LT(Least("cma_es", 3000, 1, Valley, 4), 1e-8);
}

TEST(Search, CmaEsSoonLeavesTheCornerThatItBeganIn) {
  const auto bowl = [](const Point& x) {
    double sum = 0;
    for (const double each : x) sum += (each - 0.75) * (each - 0.75);
    return sum;
  };
  const double cma_es = MedianLeast("cma_es", bowl, 100);
  EXPECT_LT(cma_es, 0.5 * MedianLeast("cross_entropy", bowl, 100));
  EXPECT_LT(cma_es, 0.5 * MedianLeast("random_search", bowl, 100));
}

TEST(Search, EveryMethodComesNearALeastInACorner) {
  const auto corner = [](const Point& x) { return x[0] + (1 - x[1]); };
  for (const char* method : kMethods) EXPECT_LT(Least(method, 300, 3, corner, 2), 0.4) << method;
}

TEST(Search, ThePointsAreWithinTheCubeAndTheSameUntilTheirCostsAreTold) {
  for (const char* method : kMethods) {
    Search search = MakeSearch(method, Point(3, 0.02), 5);
    Search again = MakeSearch(method, Point(3, 0.02), 5);
    Search other = MakeSearch(method, Point(3, 0.02), 6);
    const auto ask = [](Search& s) { return std::visit([](auto& one) { return one.Ask(); }, s); };
    for (int round = 0; round < 5; ++round) {
      const std::vector<Point> points = ask(search);
      EXPECT_EQ(points, ask(search));
      EXPECT_EQ(points, ask(again));
      EXPECT_NE(points, ask(other));
      for (const Point& point : points) EXPECT_THAT(point, Each(::testing::AllOf(Ge(0), Le(1))));
      std::vector<double> costs;
      for (const Point& point : points) costs.push_back(Valley(point));
      for (Search* each : {&search, &again, &other}) std::visit([&](auto& s) { s.Tell(costs); }, *each);
    }
  }
}

struct PagmoValley {
  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return {Valley(x)}; }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {Point(3, 0), Point(3, 1)};
  }
};

TEST(Search, CmaEsIsPagmosOwnThoughItIsAskedAndTold) {
  pagmo::population population(pagmo::problem(PagmoValley{}), 0, 0);
  for (int i = 0; i < 7; ++i) population.push_back(Point(3, 0.3), {0.0});
  const pagmo::algorithm own(pagmo::cmaes(1, -1, -1, -1, -1, kFirstStep, 0, 0, true, true, 9));
  CmaEs search(Point(3, 0.3), 9);
  for (int generation = 0; generation < 20; ++generation) {
    population = own.evolve(population);
    EXPECT_THAT(search.Ask(), ::testing::UnorderedElementsAreArray(population.get_x()));
    std::vector<double> costs;
    for (const Point& point : search.Ask()) costs.push_back(Valley(point));
    search.Tell(costs);
  }
}

}  // namespace
}  // namespace kestrel::campaign
