// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/border_belief.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

namespace {

// Fitted by ridge regression; docs/guide/horizon.md says to what. In the order of BorderFeatures.
constexpr std::array<double, kBorderFeatures> kWeights = {-3.670, 4.525,  1.725,  0.922, 1.967,  1.272,
                                                          -0.826, -0.537, 1.962,  3.213, -0.269, 1.215,
                                                          2.252,  0.363,  -1.585, 2.115};

}  // namespace

std::array<double, kBorderFeatures> BorderFeatures(const BorderLook& look, const BorderSides& sides) {
  const double above = look.rough_above + 0.5, below = look.rough_below + 0.5;
  return {
      1, look.straight, look.near, std::max(-1.0, (look.steady - 0.9) / 0.1), std::tanh(look.contrast / 40),
      std::log(below / above), -std::log(above), sides.rough_below - sides.rough_above, -sides.rough_above,
      std::tanh((sides.bright_above - sides.bright_below) / 60),
      std::tanh((sides.blue_above - sides.blue_below) / 40), std::min(2.0, sides.gain),
      std::tanh(look.brighter / 20), std::tanh((sides.green_below - sides.green_above) / 8),
      // Above the horizon the sky hardly changes; above a shore, a wood or a near ridge there is more to come.
      std::log((look.contrast + 5) / (look.drift + 5)), -std::log(look.drift + 5)};
}

std::array<double, kBorderFeatures> BorderWeights() { return kWeights; }

double BorderBelief(const BorderLook& look, const BorderSides& sides) {
  const auto features = BorderFeatures(look, sides);
  double sum = 0;
  for (std::size_t k = 0; k < features.size(); ++k) sum += kWeights[k] * features[k];
  return sum;
}

}  // namespace kestrel::vision
