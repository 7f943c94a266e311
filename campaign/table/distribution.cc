// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/distribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace kestrel::campaign {
namespace {

constexpr double kSigmas = 10;

// Of the share u of the whole, never the ends, which a normal does not have.
double StandardNormalQuantile(double u) {
  return boost::math::quantile(boost::math::normal(), std::clamp(u, 0x1p-54, 1 - 0x1p-53));
}

// Between a and b, in sigmas. In the upper tail as the mirror of the lower one, where the shares near 0
// keep their digits.
double TruncatedQuantile(double u, double a, double b) {
  if (a > 0) return -TruncatedQuantile(1 - u, -b, -a);
  const boost::math::normal normal;
  const double from = boost::math::cdf(normal, a), until = boost::math::cdf(normal, b);
  const double share = from + u * (until - from);
  if (share <= 0 || share >= 1) return share <= 0 ? a : b;
  return std::clamp(boost::math::quantile(normal, share), a, b);
}

std::string Shown(double value) { return fmt::format("{}", value); }

struct Quantile {
  double u;
  std::string operator()(const Uniform& d) const {
    return Shown(std::clamp(d.low + u * (d.high - d.low), d.low, d.high));
  }
  std::string operator()(const LogUniform& d) const {
    return Shown(std::clamp(d.low * std::exp(u * std::log(d.high / d.low)), d.low, d.high));
  }
  std::string operator()(const Normal& d) const {
    return Shown(d.mean + d.sigma * StandardNormalQuantile(u));
  }
  std::string operator()(const TruncatedNormal& d) const {
    const double z = TruncatedQuantile(u, (d.low - d.mean) / d.sigma, (d.high - d.mean) / d.sigma);
    return Shown(std::clamp(d.mean + d.sigma * z, d.low, d.high));
  }
  std::string operator()(const Choice& d) const {
    const auto count = static_cast<double>(d.values.size());
    return d.values[std::min(static_cast<std::size_t>(u * count), d.values.size() - 1)];
  }
  std::string operator()(const Grid&) const { return {}; }
};

struct Ends {
  using List = std::vector<std::string>;
  List operator()(const Normal& d) const {
    return {Shown(d.mean - kSigmas * d.sigma), Shown(d.mean + kSigmas * d.sigma)};
  }
  List operator()(const Choice& d) const { return d.values; }
  List operator()(const Grid& d) const { return d.values; }
  List operator()(const auto& d) const { return {Shown(d.low), Shown(d.high)}; }
};

}  // namespace

std::string ValueAt(const Distribution& distribution, double u) {
  return std::visit(Quantile{u}, distribution);
}

std::vector<std::string> Extremes(const Distribution& distribution) {
  return std::visit(Ends{}, distribution);
}

}  // namespace kestrel::campaign
