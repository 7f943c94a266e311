// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/paired.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "base/random.h"
#include "base/statistics.h"

namespace kestrel::campaign {
namespace {

const boost::math::normal kNormal;

// The samples with how often a resample has each.
class Resampled {
 public:
  explicit Resampled(const std::vector<double>& values) : values_(values), order_(values.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](auto i, auto j) { return values[i] < values[j]; });
  }
  // As Quantile of base/statistics.h has it.
  double QuantileOf(const std::vector<int>& times, double q) const {
    const double at = q * static_cast<double>(values_.size() - 1);
    const auto rank = static_cast<std::ptrdiff_t>(at);
    std::ptrdiff_t passed = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      passed += times[order_[i]];
      if (passed <= rank) continue;
      const double low = values_[order_[i]];
      if (passed > rank + 1 || at == static_cast<double>(rank)) return low;
      do ++i;
      while (times[order_[i]] == 0);
      return low + (at - static_cast<double>(rank)) * (values_[order_[i]] - low);
    }
    return values_[order_.back()];
  }

 private:
  const std::vector<double>& values_;
  std::vector<std::size_t> order_;
};

}  // namespace

Interval StudentInterval(const std::vector<double>& differences, double level) {
  const double n = static_cast<double>(differences.size()), mean = Mean(differences);
  double squares = 0;
  for (const double d : differences) squares += (d - mean) * (d - mean);
  const double half = boost::math::quantile(boost::math::students_t(n - 1), (1 + level) / 2) *
                      std::sqrt(squares / (n - 1) / n);
  return {mean - half, mean + half};
}

double McNemar(const PairedEnds& ends) {
  const std::int64_t differ = ends.only_a + ends.only_b;
  if (differ == 0) return 1;
  const boost::math::binomial even(static_cast<double>(differ), 0.5);
  return std::min(1.0, 2 * boost::math::cdf(even, static_cast<double>(std::min(ends.only_a, ends.only_b))));
}

Estimate ShareDifference(const PairedEnds& ends, double level) {
  const double n = static_cast<double>(ends.rows());
  if (n == 0) return {0, {-1, 1}};
  const double b = static_cast<double>(ends.only_b), c = static_cast<double>(ends.only_a);
  const double z = boost::math::quantile(kNormal, (1 + level) / 2);
  // How many deviations the observed difference lies above a true one of d. The probability q of "only A"
  // is the likeliest of those for which that of "only B" is q + d.
  const auto score = [&](double d) {
    const double half = -b - c + (2 * n - b + c) * d;
    const double q = (std::sqrt(std::max(0.0, half * half + 8 * n * c * d * (1 - d))) - half) / (4 * n);
    const double over = b - c - n * d, variance = n * (2 * q + d * (1 - d));
    if (variance > 0) return over / std::sqrt(variance);
    return over == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), over);
  };
  const auto solve = [&](double low, double high, double wanted) {
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (score(middle) > wanted ? low : high) = middle;
    }
    return (low + high) / 2;
  };
  const double value = (b - c) / n;
  return {value, {solve(-1, value, z), solve(value, 1, -z)}};
}

PairedDifferences DifferencesOf(const std::vector<double>& a, const std::vector<double>& b,
                                std::uint64_t seed, double stricter_level, int resamples) {
  const std::size_t n = a.size();
  std::vector<double> differences;
  for (std::size_t i = 0; i < n; ++i) differences.push_back(b[i] - a[i]);
  const Resampled of_a(a), of_b(b);
  std::vector<double> median, quantile_95;
  RandomStream random(seed, "bootstrap");
  std::vector<int> times(n);
  for (int i = 0; i < resamples; ++i) {
    std::fill(times.begin(), times.end(), 0);
    for (std::size_t j = 0; j < n; ++j)
      ++times[std::min(n - 1, static_cast<std::size_t>(random.Uniform(0, static_cast<double>(n))))];
    median.push_back(of_b.QuantileOf(times, 0.5) - of_a.QuantileOf(times, 0.5));
    quantile_95.push_back(of_b.QuantileOf(times, 0.95) - of_a.QuantileOf(times, 0.95));
  }
  const auto quantile = [&](double q, const std::vector<double>& replicates) {
    return PairedDifference{
        Quantile(a, q), Quantile(b, q), {Quantile(replicates, 0.025), Quantile(replicates, 0.975)}};
  };
  return {{Mean(a), Mean(b), StudentInterval(differences, 0.95)},
          quantile(0.5, median),
          quantile(0.95, quantile_95),
          StudentInterval(differences, stricter_level)};
}

}  // namespace kestrel::campaign
