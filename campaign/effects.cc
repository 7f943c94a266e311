// SPDX-License-Identifier: Apache-2.0
#include "campaign/effects.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>

#include "scenarios/statistics.h"

namespace kestrel {
namespace {

constexpr std::size_t kFewest = 10;             // pairs of which anything is said
constexpr std::int64_t kFewestOfEitherEnd = 5;  // of success and of failure

double NormalQuantile(double level) { return boost::math::quantile(boost::math::normal(), (1 + level) / 2); }

std::vector<std::size_t> OrderOf(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

// From 1; equal values have the mean of theirs.
std::vector<double> RanksOf(const std::vector<double>& values) {
  const std::vector<std::size_t> order = OrderOf(values);
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = static_cast<double>(begin + end + 1) / 2;
  }
  return ranks;
}

// Groups of neighbours of about the same size, equal values always in one.
std::vector<std::size_t> GroupsOfNeighbours(const std::vector<double>& x) {
  const std::size_t n = x.size();
  const std::size_t groups = std::clamp<std::size_t>(n / 10, 2, 32);
  const std::vector<std::size_t> order = OrderOf(x);
  std::vector<std::size_t> group(n);
  std::size_t current = 0;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && x[order[end]] == x[order[begin]]) ++end;
    const std::size_t wanted = (begin + end) / 2 * groups / n;  // where the middle of the equal ones lies
    current = std::max(current, wanted);
    for (std::size_t i = begin; i < end; ++i) group[order[i]] = current;
  }
  return group;
}

}  // namespace

std::optional<double> NumberIn(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Estimate> RankCorrelation(const std::vector<double>& x, const std::vector<double>& y,
                                        double level) {
  const double n = static_cast<double>(x.size());
  if (x.size() < kFewest) return std::nullopt;
  const std::vector<double> a = RanksOf(x), b = RanksOf(y);
  const double mean = (n + 1) / 2;
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean) * (b[i] - mean);
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
  }
  if (aa == 0 || bb == 0) return std::nullopt;
  const double r = std::clamp(ab / std::sqrt(aa * bb), -1.0, 1.0);
  if (std::abs(r) == 1) return Estimate{r, {r, r}};
  const double half = NormalQuantile(level) * std::sqrt((1 + r * r / 2) / (n - 3));
  return Estimate{r, {std::tanh(std::atanh(r) - half), std::tanh(std::atanh(r) + half)}};
}

std::optional<Estimate> ShareBetweenGroups(const std::vector<std::size_t>& groups,
                                           const std::vector<double>& y, double level) {
  if (y.size() < kFewest) return std::nullopt;
  const double n = static_cast<double>(y.size()), mean = Mean(y);
  std::map<std::size_t, std::pair<double, double>> sums;  // of y less its mean, by group; how many
  for (std::size_t i = 0; i < y.size(); ++i) {
    auto& [sum, count] = sums[groups[i]];
    sum += y[i] - mean, count += 1;
  }
  const double k = static_cast<double>(sums.size());
  double total = 0, within = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const auto& [sum, count] = sums.at(groups[i]);
    const double d = y[i] - mean, e = d - sum / count;
    total += d * d, within += e * e;
  }
  if (k < 2 || k >= n || total <= 0) return std::nullopt;
  const double variance = total / n;
  const double index = 1 - (within / (n - k)) / (total / (n - 1));
  // The influence of one sample on N / V, N being the variance of the groups' means m and V that of y (both
  // about the mean): ((2 m y - m^2 - N) - index (y^2 - V)) / V.
  double squares = 0, influence_sum = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const auto& [sum, count] = sums.at(groups[i]);
    const double d = y[i] - mean, m = sum / count;
    const double influence = (2 * m * d - m * m - index * d * d) / variance;
    squares += influence * influence, influence_sum += influence;
  }
  const double spread = squares / n - influence_sum / n * influence_sum / n;
  const double half = NormalQuantile(level) * std::sqrt(std::max(0.0, spread) / n);
  return Estimate{index, {std::clamp(index - half, 0.0, 1.0), std::clamp(index + half, 0.0, 1.0)}};
}

std::optional<Estimate> FirstOrderIndex(const std::vector<double>& x, const std::vector<double>& y,
                                        double level) {
  if (x.size() < kFewest) return std::nullopt;
  return ShareBetweenGroups(GroupsOfNeighbours(x), y, level);
}

std::vector<Effect> EffectsOf(const SampleTable& table, const std::vector<RunResult>& results,
                              const std::vector<std::string>& metrics) {
  std::vector<Effect> effects;
  for (std::size_t k = 0; k < table.keys.size(); ++k) {
    if (table.keys[k] == "seed") continue;
    std::map<std::string, std::size_t> choices;
    bool numeric = true;
    for (const auto& row : table.rows) {
      choices.emplace(row[k], choices.size());
      numeric = numeric && NumberIn(row[k]);
    }
    if (choices.size() < 2) continue;
    for (const std::string& metric : metrics) {
      std::vector<double> x, y;
      std::vector<std::size_t> chosen;
      for (const RunResult& result : results) {
        const std::string& text = table.rows.at(static_cast<std::size_t>(result.row))[k];
        const auto found = result.metrics.find(metric);
        if (metric == "success")
          y.push_back(result.status == RunStatus::kPassed);
        else if (found != result.metrics.end() && std::isfinite(found->second))
          y.push_back(found->second);
        else
          continue;
        x.push_back(numeric ? *NumberIn(text) : 0);
        chosen.push_back(choices.at(text));
      }
      if (metric == "success") {
        const auto passed = std::count(y.begin(), y.end(), 1.0);
        if (std::min<std::int64_t>(passed, std::ssize(y) - passed) < kFewestOfEitherEnd) continue;
      }
      Effect effect{table.keys[k], metric, std::ssize(y), numeric, {}, {}};
      if (numeric) {
        effect.rank_correlation = RankCorrelation(x, y);
        effect.first_order = FirstOrderIndex(x, y);
      } else {
        effect.first_order = ShareBetweenGroups(chosen, y);
      }
      if (effect.rank_correlation || effect.first_order) effects.push_back(std::move(effect));
    }
  }
  return effects;
}

}  // namespace kestrel
