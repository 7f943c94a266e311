// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/pagmo_eigen.h"
// before the others
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

#include "campaign/tuning/search.h"

namespace kestrel::campaign {
namespace {

// pagmo evaluates the points of a generation one after the other, from within. A generation does not look at
// its costs before all of its points are drawn, so it is gone through twice: a copy of the algorithm, random
// numbers and all, is told nothing and shows the points; then the algorithm itself finds their costs here.
struct Exchange {
  bool asking = false;
  std::vector<Point> asked;
  std::map<Point, double> told;
};

struct Asked {
  std::shared_ptr<Exchange> exchange;
  std::size_t dimension = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& x) const {
    if (!exchange->asking) return {exchange->told.at(x)};
    exchange->asked.push_back(x);
    return {0.0};
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {Point(dimension, 0.0), Point(dimension, 1.0)};
  }
};

}  // namespace

struct CmaEs::State {
  std::shared_ptr<Exchange> exchange = std::make_shared<Exchange>();
  pagmo::algorithm algorithm;
  pagmo::population population;
  Point centre;
};

CmaEs::CmaEs(const Point& start, std::uint64_t seed) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.centre = start;
  // One generation at a time, going on from the one before; the default rates; no end of its own. Within the
  // bounds: were the walls mirrors, a mean beside one would be drawn to both of its sides and stay there.
  s.algorithm = pagmo::algorithm(pagmo::cmaes(1, -1, -1, -1, -1, kFirstStep, 0, 0, true, true,
                                              static_cast<unsigned>(seed ^ seed >> 32)));
  s.population = pagmo::population(pagmo::problem(Asked{s.exchange, start.size()}), 0, 0);
  const auto size = static_cast<int>(4 + 3 * std::log(static_cast<double>(start.size())));
  for (int i = 0; i < std::max(size, 6); ++i) s.population.push_back(start, {0.0});
}

CmaEs::~CmaEs() = default;
CmaEs::CmaEs(CmaEs&&) noexcept = default;
CmaEs& CmaEs::operator=(CmaEs&&) noexcept = default;

const std::vector<Point>& CmaEs::Ask() {
  State& s = *state_;
  std::vector<Point>& asked = s.exchange->asked;
  if (!asked.empty()) return asked;
  s.exchange->asking = true;
  pagmo::algorithm(s.algorithm).evolve(s.population);
  s.exchange->asking = false;
  return asked;
}

void CmaEs::Tell(const std::vector<double>& costs) {
  State& s = *state_;
  const std::vector<Point> asked = std::exchange(s.exchange->asked, {});
  assert(costs.size() == asked.size());
  s.exchange->told.clear();
  for (std::size_t i = 0; i < costs.size(); ++i) s.exchange->told[asked[i]] = costs[i];
  s.population = s.algorithm.evolve(s.population);
  // Its mean, which pagmo keeps to itself: the best half, the better the heavier.
  const std::vector<std::size_t> order = ByCost(costs);
  const double half = std::floor(static_cast<double>(costs.size()) / 2);
  Point sum(s.centre.size(), 0.0);
  double weights = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(half); ++k) {
    const double weight = std::log(half + 0.5) - std::log(static_cast<double>(k) + 1);
    weights += weight;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * asked[order[k]][i];
  }
  for (double& x : sum) x /= weights;
  s.centre = sum;
}

const Point& CmaEs::Centre() const { return state_->centre; }

}  // namespace kestrel::campaign
