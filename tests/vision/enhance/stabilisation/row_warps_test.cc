// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/row_warps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::vision {
namespace {

// Images at 0, 1, 2, ... of a camera whose picture sways sideways, row by row.
double Sway(double t, double frequency) { return 5 * std::sin(2 * std::numbers::pi * frequency * t + 0.4); }

TEST(RowWarps, UndoASwayOfAThirdOfTheRateOfImages) {
  constexpr int kSide = 6;
  constexpr double kReadout = 0.9;
  for (const double frequency : {0.05, 0.15, 0.3}) {
    double worst = 0, skew = 0;
    const double rows[] = {-0.5, -0.25, 0.0, 0.25, 0.5};  // 0: the middle one
    for (std::size_t i = 0; i < 5; ++i) {
      // By what is seen at this row.
      const double late = kReadout * rows[i];
      std::vector<Eigen::Matrix3d> to(2 * kSide + 1, Eigen::Matrix3d::Identity());
      for (int k = -kSide; k <= kSide; ++k)
        to[static_cast<std::size_t>(kSide + k)](0, 2) = Sway(k + late, frequency) - Sway(late, frequency);
      const auto warps = RowWarps(to, kReadout);
      const double moved = warps[2 * i](0, 2), truth = Sway(late, frequency) - Sway(0, frequency);
      worst = std::max(worst, std::abs(moved - truth)), skew = std::max(skew, std::abs(truth));
    }
    EXPECT_LT(worst, 0.1 * skew) << frequency;
  }
}

}  // namespace
}  // namespace kestrel::vision
