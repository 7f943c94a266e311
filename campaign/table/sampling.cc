// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/sampling.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/random.h"
#include "campaign/table/scrambled_sobol.h"

namespace kestrel::campaign {
namespace {

using Column = std::vector<double>;  // shares in [0, 1)

constexpr double kMinShare = 0x1p-54, kMaxShare = 1 - 0x1p-53;

template <class T>
std::vector<int> Order(const std::vector<T>& values) {  // the least first
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  return order;
}

RandomStream StreamOf(const CampaignPlan& plan, const std::string& key, int point) {
  return {plan.seed, fmt::format("campaign {} at {}", key, point)};
}

Column Independent(RandomStream random, int runs) {
  Column column(runs);
  for (double& u : column) u = random.Uniform(0, 1);
  return column;
}

Column LatinHypercube(RandomStream random, int runs) {
  Column jitter(runs), column(runs);
  std::vector<std::uint64_t> lots(runs);
  for (int i = 0; i < runs; ++i) jitter[i] = random.Uniform(0, 1), lots[i] = random.Bits();
  const std::vector<int> order = Order(lots);
  for (int stratum = 0; stratum < runs; ++stratum) {
    // A sum may round up into the next stratum.
    column[order[stratum]] =
        std::min((stratum + jitter[stratum]) / runs, std::nextafter((stratum + 1.0) / runs, 0.0));
  }
  return column;
}

// Of each key that is drawn, at one point of the grid.
std::map<std::string, Column> DrawColumns(const CampaignPlan& plan, const std::vector<std::string>& keys,
                                          int point) {
  std::map<std::string, Column> columns;
  if (plan.sampling == "sobol") {
    std::vector<std::uint64_t> seeds;
    for (const std::string& key : keys) seeds.push_back(StreamOf(plan, key, point).Bits());
    const auto drawn = ScrambledSobol(plan.runs, seeds);
    for (std::size_t k = 0; k < keys.size(); ++k) columns[keys[k]] = drawn[k];
  } else {
    for (const std::string& key : keys)
      columns[key] = (plan.sampling == "independent" ? Independent : LatinHypercube)(
          StreamOf(plan, key, point), plan.runs);
  }
  return columns;
}

void Correlate(const CampaignPlan& plan, const CorrelatedGroup& group,
               std::map<std::string, Column>& columns) {
  const auto size = static_cast<Eigen::Index>(group.keys.size());
  Eigen::MatrixXd correlation =
      Eigen::MatrixXd::Constant(size, size, CopulaCorrelation(group.rank_correlation));
  correlation.diagonal().setOnes();
  const Eigen::MatrixXd root = correlation.llt().matrixL();
  const boost::math::normal normal;
  Eigen::MatrixXd z(size, plan.runs);
  for (Eigen::Index k = 0; k < size; ++k) {
    const Column& column = columns.at(group.keys[k]);
    for (int i = 0; i < plan.runs; ++i)
      z(k, i) = boost::math::quantile(normal, std::clamp(column[i], kMinShare, kMaxShare));
  }
  z = (root * z).eval();
  for (Eigen::Index k = 1; k < size; ++k) {  // the first is what it was
    Column& column = columns.at(group.keys[k]);
    Column shares(plan.runs);
    for (int i = 0; i < plan.runs; ++i)
      shares[i] = std::clamp(boost::math::cdf(normal, z(k, i)), 0.0, kMaxShare);
    if (plan.sampling == "latin_hypercube") {
      const std::vector<int> wanted = Order(shares);
      std::sort(column.begin(), column.end());
      for (int rank = 0; rank < plan.runs; ++rank) shares[wanted[rank]] = column[rank];
    }
    column = std::move(shares);
  }
}

}  // namespace

std::uint64_t SeedOfRow(std::uint64_t campaign_seed, std::int64_t row) {
  // One step of splitmix64 from another start for each campaign: a bijection of the row.
  return RandomStream::Mix(RandomStream(campaign_seed, "campaign seeds").Bits() +
                           static_cast<std::uint64_t>(row));
}

double CopulaCorrelation(double rank_correlation) {
  return 2 * std::sin(std::numbers::pi * rank_correlation / 6);
}

double MinRankCorrelation(int keys) {
  return 6 / std::numbers::pi * std::asin(-0.5 / (keys - 1));  // 1 + (keys - 1) rho > 0
}

SampleTable DrawTable(const CampaignPlan& plan) {
  SampleTable table{{"seed"}, {}};
  std::vector<std::string> drawn;
  int points = 1;
  for (const auto& [key, distribution] : plan.vary) {
    if (key != "seed") table.keys.push_back(key);
    if (const auto* grid = std::get_if<Grid>(&distribution))
      points *= static_cast<int>(grid->values.size());
    else
      drawn.push_back(key);
  }
  const std::size_t own = table.keys.size();
  for (const SameValue& same : plan.same) table.keys.push_back(same.key);
  table.rows.resize(static_cast<std::size_t>(plan.runs) * points);
  for (int point = 0; point < points; ++point) {
    auto columns = DrawColumns(plan, drawn, point);
    for (const CorrelatedGroup& group : plan.correlated) Correlate(plan, group, columns);
    std::map<std::string, std::string> at_point;
    int rest = point;
    for (auto it = plan.vary.rbegin(); it != plan.vary.rend(); ++it) {
      const auto* grid = std::get_if<Grid>(&it->second);
      if (!grid) continue;
      const int size = static_cast<int>(grid->values.size());
      at_point[it->first] = grid->values[rest % size];
      rest /= size;
    }
    for (int run = 0; run < plan.runs; ++run) {
      const std::int64_t row = static_cast<std::int64_t>(run) * points + point;
      for (std::size_t k = 0; k < table.keys.size(); ++k) {
        const std::string& key = k < own ? table.keys[k] : plan.same[k - own].as;
        const auto vary = plan.vary.find(key);
        if (vary == plan.vary.end())
          table.rows[row].push_back(std::to_string(SeedOfRow(plan.seed, row)));
        else if (std::holds_alternative<Grid>(vary->second))
          table.rows[row].push_back(at_point.at(key));
        else
          table.rows[row].push_back(ValueAt(vary->second, columns.at(key)[run]));
      }
    }
  }
  return table;
}

}  // namespace kestrel::campaign
