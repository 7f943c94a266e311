// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

#include "base/random.h"

namespace kestrel::campaign {
namespace {

// The point within the unit cube that a point beyond its walls, which are mirrors, is seen at.
Point Reflected(Point point) {
  for (double& x : point) {
    const double along = std::fmod(std::abs(x), 2.0);
    x = along <= 1 ? along : 2 - along;
  }
  return point;
}

}  // namespace

std::vector<std::size_t> ByCost(const std::vector<double>& costs) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return costs[a] < costs[b]; });
  return order;
}

CrossEntropy::CrossEntropy(Point start, std::uint64_t seed)
    : seed_(seed), mean_(std::move(start)), sigma_(mean_.size(), kFirstStep) {}

const std::vector<Point>& CrossEntropy::Ask() {
  if (!asked_.empty()) return asked_;
  RandomStream random(seed_, fmt::format("cross-entropy {}", generation_));
  // The spread of each side is judged by the best quarter alone: five of them at least.
  asked_.resize(std::max<std::size_t>(20, 4 * mean_.size()));
  for (Point& point : asked_) {
    point.resize(mean_.size());
    for (std::size_t i = 0; i < point.size(); ++i) point[i] = mean_[i] + sigma_[i] * random.Normal();
    point = Reflected(point);
  }
  return asked_;
}

void CrossEntropy::Tell(const std::vector<double>& costs) {
  constexpr double kSmoothing = 0.8;  // share of the new
  const std::size_t elite = asked_.size() / 4;
  const std::vector<std::size_t> order = ByCost(costs);
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < elite; ++k) sum += asked_[order[k]][i];
    const double mean = sum / static_cast<double>(elite);
    for (std::size_t k = 0; k < elite; ++k) squares += std::pow(asked_[order[k]][i] - mean, 2);
    mean_[i] += kSmoothing * (mean - mean_[i]);
    sigma_[i] += kSmoothing * (std::sqrt(squares / static_cast<double>(elite - 1)) - sigma_[i]);
  }
  asked_.clear(), ++generation_;
}

RandomSearch::RandomSearch(Point start, std::uint64_t seed)
    : seed_(seed), best_(std::move(start)), min_(std::numeric_limits<double>::infinity()) {}

const std::vector<Point>& RandomSearch::Ask() {
  if (!asked_.empty()) return asked_;
  RandomStream random(seed_, fmt::format("random search {}", generation_));
  asked_.resize(8);
  for (Point& point : asked_) {
    point.resize(best_.size());
    for (double& x : point) x = random.Uniform(0, 1);
  }
  return asked_;
}

void RandomSearch::Tell(const std::vector<double>& costs) {
  const std::size_t best = ByCost(costs).front();
  if (costs[best] < min_) best_ = asked_[best], min_ = costs[best];
  asked_.clear(), ++generation_;
}

bool ComparesRounds(const Search& search) {
  return std::visit([](const auto& s) { return std::decay_t<decltype(s)>::kComparesRounds; }, search);
}

Search MakeSearch(const std::string& method, const Point& start, std::uint64_t seed) {
  if (method == "cross_entropy") return CrossEntropy(start, seed);
  if (method == "random_search") return RandomSearch(start, seed);
  assert(method == "cma_es");
  return CmaEs(start, seed);
}

}  // namespace kestrel::campaign
