// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/effects.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>

#include "base/statistics.h"

namespace kestrel::campaign {
namespace {

constexpr std::size_t kFewest = 10;          // pairs of which anything is said
constexpr std::size_t kMinForIndex = 50;     // of two groups of neighbours and their lines
constexpr std::int64_t kMinOfEitherEnd = 5;  // of success and of failure

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
  const std::size_t groups = std::clamp<std::size_t>(n / 20, 2, 16);
  const std::vector<std::size_t> order = OrderOf(x);
  std::vector<std::size_t> group(n);
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && x[order[end]] == x[order[begin]]) ++end;
    const std::size_t where = (begin + end) / 2 * groups / n;  // the middle of the equal ones
    for (std::size_t i = begin; i < end; ++i) group[order[i]] = where;
  }
  return group;
}

// What is expected of y, in deviations from its mean, and with how many parameters that was fitted.
struct Fit {
  std::vector<double> values;
  double parameters = 0;
};

// The groups' means; where x is given, a straight line in x for each group.
Fit FitOf(const std::vector<std::size_t>& groups, const std::vector<double>& deviations,
          const std::vector<double>* x) {
  struct Sums {
    double count = 0, x = 0, y = 0, xx = 0, xy = 0;
  };
  std::map<std::size_t, Sums> sums;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Sums& s = sums[groups[i]];
    s.count += 1, s.y += deviations[i];
    if (x) s.x += (*x)[i];
  }
  Fit fit;
  if (x)
    for (std::size_t i = 0; i < groups.size(); ++i) {
      Sums& s = sums[groups[i]];
      const double from = (*x)[i] - s.x / s.count;
      s.xx += from * from, s.xy += from * deviations[i];
    }
  for (const auto& [group, s] : sums) fit.parameters += s.xx > 0 ? 2 : 1;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Sums& s = sums[groups[i]];
    const double slope = s.xx > 0 ? s.xy / s.xx : 0;
    fit.values.push_back(s.y / s.count + (x ? slope * ((*x)[i] - s.x / s.count) : 0));
  }
  return fit;
}

// The share of y's variance that a fit explains, less what chance lets it explain.
std::optional<Estimate> ShareExplained(const std::vector<std::size_t>& groups, const std::vector<double>& y,
                                       const std::vector<double>* x, double level) {
  if (y.size() < kFewest) return std::nullopt;
  const double n = static_cast<double>(y.size()), mean = Mean(y);
  std::vector<double> deviations;
  for (const double each : y) deviations.push_back(each - mean);
  const Fit fit = FitOf(groups, deviations, x);
  double total = 0, left = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double rest = deviations[i] - fit.values[i];
    total += deviations[i] * deviations[i], left += rest * rest;
  }
  if (fit.parameters < 2 || fit.parameters >= n || total <= 0) return std::nullopt;
  const double variance = total / n, index = 1 - (left / (n - fit.parameters)) / (total / (n - 1));
  // The influence of a sample on N / V, N being the variance of the expectation m and V that of y:
  // (2 m y - m^2 - N - index (y^2 - V)) / V, y and m about the mean.
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double d = deviations[i], m = fit.values[i];
    const double influence = (2 * m * d - m * m - index * d * d) / variance;
    sum += influence, squares += influence * influence;
  }
  const double spread = std::max(0.0, squares / n - sum / n * sum / n);
  // Where the index is about zero its influence vanishes; what is left is the chance of the fit itself.
  const double of_fit = 2 * (fit.parameters - 1) * (1 - index) * (1 - index) / (n * n);
  const double half = NormalQuantile(level) * std::sqrt(spread / (n - fit.parameters) + of_fit);
  return Estimate{index,
                  {std::clamp(index - half, 0.0, 1.0), std::clamp(std::max(0.0, index) + half, 0.0, 1.0)}};
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
  return ShareExplained(groups, y, nullptr, level);
}

std::optional<Estimate> FirstOrderIndex(const std::vector<double>& x, const std::vector<double>& y,
                                        double level) {
  if (x.size() < kMinForIndex) return std::nullopt;
  const std::vector<double> ranks = RanksOf(x);
  return ShareExplained(GroupsOfNeighbours(x), y, &ranks, level);
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
        if (std::min<std::int64_t>(passed, std::ssize(y) - passed) < kMinOfEitherEnd) continue;
      }
      const auto shown = [](std::optional<Estimate> index) {
        if (index) index->value = std::clamp(index->value, 0.0, 1.0);
        return index;
      };
      Effect effect{table.keys[k], metric, std::ssize(y), numeric, {}, {}};
      if (numeric) {
        effect.rank_correlation = RankCorrelation(x, y);
        effect.first_order = shown(FirstOrderIndex(x, y));
      } else {
        effect.first_order = shown(ShareBetweenGroups(chosen, y));
      }
      if (effect.rank_correlation || effect.first_order) effects.push_back(std::move(effect));
    }
  }
  return effects;
}

}  // namespace kestrel::campaign
