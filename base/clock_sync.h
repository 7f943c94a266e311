// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <utility>

namespace kestrel {

// The time of another computer's clock on ours, from when its stamped messages came: the fastest message of
// the last while had the least delay, and that is taken for the offset. It is late by the shortest delay of
// the line, which stamps alone cannot tell. A clock that was set anew (it jumps by more than kJump_s) begins
// anew.
class ClockSync {
 public:
  static constexpr double kWindow_s = 10, kJump_s = 1;

  void AddSample(double their_s, double ours_s);       // a message stamped by them, and when it came
  std::optional<double> ToOurs(double their_s) const;  // none: nothing heard

 private:
  // Offsets ours - theirs that are the least of all that came after them, with when they came: rising.
  std::deque<std::pair<double, double>> min_;
};

}  // namespace kestrel
