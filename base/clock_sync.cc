// SPDX-License-Identifier: Apache-2.0
#include "base/clock_sync.h"

#include <cmath>

namespace kestrel {

void ClockSync::AddSample(double their_s, double ours_s) {
  const double offset = ours_s - their_s;
  if (!std::isfinite(offset)) return;
  if (!min_.empty() && std::abs(offset - min_.front().second) > kJump_s) min_.clear();
  while (!min_.empty() && min_.front().first < ours_s - kWindow_s) min_.pop_front();
  while (!min_.empty() && min_.back().second >= offset) min_.pop_back();
  min_.emplace_back(ours_s, offset);
}

std::optional<double> ClockSync::ToOurs(double their_s) const {
  if (min_.empty()) return std::nullopt;
  return their_s + min_.front().second;
}

}  // namespace kestrel
