// SPDX-License-Identifier: Apache-2.0
#include "base/real_time.h"

namespace kestrel {

double RealTime::Due(double wall_s, double t_s) {
  const double late_s = wall_s - zero_s_ - t_s;
  if (late_s > kCatchUp_s) {
    zero_s_ += late_s - kCatchUp_s;
    stretched_s_ += late_s - kCatchUp_s;
  }
  return wall_s - zero_s_;
}

std::optional<double> RealTime::News(double wall_s) {
  if (stretched_s_ <= told_s_ || wall_s < told_wall_s_ + 1) return std::nullopt;
  const double news_s = stretched_s_ - told_s_;
  told_s_ = stretched_s_;
  told_wall_s_ = wall_s;
  return news_s;
}

}  // namespace kestrel
