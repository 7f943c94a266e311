// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace kestrel::flight {

// How many messages of a viewer are read: kAtOnce, and kPerSecond from then on. One that goes on for
// kPatience messages beyond is put out.
class RateLimit {
 public:
  static constexpr double kAtOnce = 50, kPerSecond = 20;
  static constexpr int kPatience = 1000;
  enum class Verdict { kTake, kRefuse, kPutOut };

  Verdict Take(double now_s) {
    left_ = std::min(kAtOnce, left_ + kPerSecond * std::max(0.0, now_s - last_s_));
    last_s_ = now_s;
    if (left_ >= 1) {
      left_ -= 1;
      refused_ = 0;
      return Verdict::kTake;
    }
    return ++refused_ > kPatience ? Verdict::kPutOut : Verdict::kRefuse;
  }
  bool first_refused() const { return refused_ == 1; }

 private:
  double left_ = kAtOnce, last_s_ = 0;
  int refused_ = 0;  // since one was taken
};

}  // namespace kestrel::flight
