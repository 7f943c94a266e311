// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/intervals.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>

#include "base/statistics.h"

namespace kestrel::campaign {
namespace {

// The W of which Hall's g(W) = ((1 + skew W / 3)^3 - 1) / skew + skew / (6 n) is y.
double HallInverse(double y, double skew, double n) {
  const double u = skew * (y - skew / (6 * n));
  if (std::abs(u) < 1e-12) return y;
  const double root = u > -0.5 ? std::expm1(std::log1p(u) / 3) : std::cbrt(1 + u) - 1;
  return 3 / skew * root;
}

}  // namespace

Estimate MeanOf(const std::vector<double>& samples, double level) {
  if (samples.empty()) return {};
  const double n = static_cast<double>(samples.size()), mean = Mean(samples);
  if (samples.size() < 2 || !std::isfinite(mean)) return {mean, {}};
  double second = 0, third = 0;
  for (const double x : samples) {
    const double d = x - mean;
    second += d * d, third += d * d * d;
  }
  if (second == 0) return {mean, {mean, mean}};
  const double sigma = std::sqrt(second / (n - 1));
  const double skew = third / n / std::pow(second / n, 1.5);
  const double t = boost::math::quantile(boost::math::students_t(n - 1), (1 + level) / 2);
  const auto end = [&](double y) { return mean - sigma * HallInverse(y / std::sqrt(n), skew, n); };
  Interval interval{end(t), end(-t)};
  const auto [min, max] = std::minmax_element(samples.begin(), samples.end());
  if (interval.low < *min) interval.low = Interval().low;
  if (interval.high > *max) interval.high = Interval().high;
  return {mean, interval};
}

Estimate QuantileOf(std::vector<double> samples, double q, double level) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  Estimate estimate{Quantile(samples, q), {}};
  // Of n samples, as many lie below the quantile as a binomial of n and q says. The sample of rank r (from 1)
  // is above it with probability P(B < r), and below it with P(B >= r).
  const boost::math::binomial below(static_cast<double>(samples.size()), q);
  const double tail = (1 - level) / 2;
  const auto ranks = static_cast<std::ptrdiff_t>(samples.size());
  const auto first = [&](auto&& holds) {  // rank for which it holds; it holds for all after that
    std::ptrdiff_t low = 1, high = ranks + 1;
    while (low < high) {
      const std::ptrdiff_t middle = (low + high) / 2;
      holds(static_cast<double>(middle)) ? high = middle : low = middle + 1;
    }
    return low;
  };
  const std::ptrdiff_t low = first([&](double rank) { return boost::math::cdf(below, rank - 1) > tail; }) - 1;
  const std::ptrdiff_t high =
      first([&](double rank) { return boost::math::cdf(boost::math::complement(below, rank - 1)) <= tail; });
  if (low >= 1) estimate.interval.low = samples[static_cast<std::size_t>(low - 1)];
  if (high <= ranks) estimate.interval.high = samples[static_cast<std::size_t>(high - 1)];
  return estimate;
}

}  // namespace kestrel::campaign
