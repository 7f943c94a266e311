// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A picture as a printer and the weather leave it, which is never quite the file that it was drawn from.
struct PrintParameters {
  double black = 0, white = 255;  // greys that they come out as
  double grain_grey = 0;          // standard deviation
  double grain_mm = 1;            // size of a grain
  double spread_mm = 0;           // of the ink: standard deviation of a Gaussian

  friend bool operator==(const PrintParameters&, const PrintParameters&) = default;
};

inline void Fields(FieldVisitor& v, PrintParameters& p) {
  v({"black", "grey of 255 that black comes out as"}, p.black, 0.0, 200.0);
  v({"white", "grey of 255 that white comes out as"}, p.white, 20.0, 255.0);
  v({"grain_grey", "standard deviation of the grain of ink and paper, grey levels of 255"}, p.grain_grey, 0.0,
    100.0);
  v({"grain_mm", "size of a grain"}, p.grain_mm, 0.1, 1000.0);
  v({"spread_mm", "how far the ink spreads: standard deviation of a Gaussian"}, p.spread_mm, 0.0, 20.0);
}

// picture: CV_8UC1 or CV_8UC3; size_m: its height and width. The grain is drawn by the seed.
cv::Mat Printed(const cv::Mat& picture, const Eigen::Vector2d& size_m, const PrintParameters& print,
                std::uint64_t seed);

}  // namespace kestrel::sim
