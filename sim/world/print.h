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
  double shade = 0;               // share of it that lies in the shade of something, to one side
  double shade_light = 0.35;      // of the light, there
  double wet = 0;  // share of it that is wet, in blots: darker, and a mirror to some of the sky

  friend bool operator==(const PrintParameters&, const PrintParameters&) = default;
};

inline void Fields(FieldVisitor& v, PrintParameters& p) {
  v({"black", "grey of 255 that black comes out as"}, p.black, 0.0, 200.0);
  v({"white", "grey of 255 that white comes out as"}, p.white, 20.0, 255.0);
  v({"grain_grey", "standard deviation of the grain of ink and paper, grey levels of 255"}, p.grain_grey, 0.0,
    100.0);
  v({"grain_mm", "size of a grain"}, p.grain_mm, 0.1, 1000.0);
  v({"spread_mm", "how far the ink spreads: standard deviation of a Gaussian"}, p.spread_mm, 0.0, 20.0);
  v({"shade", "share of the picture that lies in the shade, to one side that is drawn by the seed"}, p.shade,
    0.0, 1.0);
  v({"shade_light", "share of the light that is left in the shade"}, p.shade_light, 0.0, 1.0);
  v({"wet", "share of the picture that is wet, in blots at places drawn by the seed"}, p.wet, 0.0, 1.0);
}

// picture: CV_8UC1 or CV_8UC3; size_m: its height and width. Grain, shade and blots are drawn by the seed.
cv::Mat Printed(const cv::Mat& picture, const Eigen::Vector2d& size_m, const PrintParameters& print,
                std::uint64_t seed);

}  // namespace kestrel::sim
