// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/speed_ratio.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace kestrel::bench {
namespace {

SpeedVerdict VerdictOf(const Interval& ratio) {
  if (ratio.low > 1) return SpeedVerdict::kSlower;
  if (ratio.high < 1) return SpeedVerdict::kFaster;
  return ratio.high < 1 + kTold && ratio.low > 1 / (1 + kTold) ? SpeedVerdict::kSame : SpeedVerdict::kUnclear;
}

}  // namespace

double LogRatioOf(const std::vector<BlockPair>& blocks) {
  std::vector<double> logs;
  for (const BlockPair& pair : blocks) logs.push_back(std::log(pair.now / pair.before));
  return Quantile(logs, 0.5);
}

const char* NameOf(SpeedVerdict verdict) {
  switch (verdict) {
    case SpeedVerdict::kSame:
      return "same";
    case SpeedVerdict::kSlower:
      return "slower";
    case SpeedVerdict::kFaster:
      return "faster";
    case SpeedVerdict::kUnclear:
      return "unclear";
  }
  return "";
}

double LevelOfEach(std::size_t rows) {
  return 1 - (1 - kTableLevel) / static_cast<double>(std::max<std::size_t>(rows, 1));  // Bonferroni
}

SpeedRatio RatioOf(const std::vector<double>& rounds, double level) {
  const campaign::Estimate logs = campaign::QuantileOf(rounds, 0.5, level);
  const Interval ratio{std::exp(logs.interval.low), std::exp(logs.interval.high)};
  return {{std::exp(logs.value), ratio}, VerdictOf(ratio)};
}

SpeedRatio Widest(const std::vector<SpeedRatio>& answers) {
  SpeedRatio widest = answers.front();
  double log_sum = 0;
  for (const SpeedRatio& each : answers) {
    Interval& all = widest.ratio.interval;
    all.low = std::min(all.low, each.ratio.interval.low);
    all.high = std::max(all.high, each.ratio.interval.high);
    log_sum += std::log(each.ratio.value);
  }
  widest.ratio.value = std::exp(log_sum / static_cast<double>(answers.size()));
  widest.verdict = VerdictOf(widest.ratio.interval);
  return widest;
}

}  // namespace kestrel::bench
