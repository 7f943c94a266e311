// SPDX-License-Identifier: Apache-2.0
#include "base/clock_sync.h"

#include <cmath>

namespace kestrel {

void ClockSync::Hear(double their_s, double ours_s) {
  const double offset = ours_s - their_s;
  if (!std::isfinite(offset)) return;
  if (!least_.empty() && std::abs(offset - least_.front().second) > kJump_s) least_.clear();
  while (!least_.empty() && least_.front().first < ours_s - kWindow_s) least_.pop_front();
  while (!least_.empty() && least_.back().second >= offset) least_.pop_back();
  least_.emplace_back(ours_s, offset);
}

std::optional<double> ClockSync::ToOurs(double their_s) const {
  if (least_.empty()) return std::nullopt;
  return their_s + least_.front().second;
}

}  // namespace kestrel
