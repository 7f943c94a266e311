// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/progress_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "campaign/counted.h"

namespace kestrel::app {
namespace {

constexpr double kEvery_s = 30;

// "3 min 20 s"
std::string Duration(double seconds) {
  const auto s = static_cast<std::int64_t>(std::min(seconds, 1e9) + 0.5);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
  return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
}

}  // namespace

std::string TimeLeft(const campaign::Progress& p) {
  if (p.flown == 0 || p.Rate() == 0) return "";
  return fmt::format("{:.3g} runs/min, {} left", 60 * p.Rate(),
                     Duration(static_cast<double>(p.rows - p.done) / p.Rate()));
}

std::string ProgressLog::Line(const campaign::Progress& p) {
  const std::int64_t tenths = p.rows > 0 ? 10 * p.done / p.rows : 10;
  if (tenths_ < 0) tenths_ = tenths;  // what was there before is no progress
  if (tenths == tenths_ && p.wall_s < told_s_ + kEvery_s) return "";
  tenths_ = tenths;
  told_s_ = p.wall_s;
  const std::string left = TimeLeft(p);
  return fmt::format("{}: {} of {}, {} passed{}{}\n", name_, p.done, campaign::Counted(p.rows, "run"),
                     p.passed, left.empty() ? "" : ", ", left);
}

}  // namespace kestrel::app
