// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/horizon/panorama_strip.h"

namespace kestrel::vision {

// One azimuth of a strip, from the lowest row up; the first and the last row, and what is not shown, count nothing.
struct StripColumn {
  static constexpr int kRows = 16;                            // whole registers
  std::array<float, kRows> pattern{}, by_column{}, by_row{};  // and its slopes
  std::array<float, kRows> shown{};                           // 1 or 0
};

// A strip made ready for matching.
struct StripReference {
  PanoramaStrip strip;
  std::vector<StripColumn> columns;
  // Spectra along the rows at half the columns: of the pattern, its square and of what is shown.
  cv::Mat spectrum, spectrum_square, spectrum_shown;
};
StripReference MakeReference(PanoramaStrip strip);

// How alike two strips are when `now` is turned clockwise from `then` by k * 2 pi / n, k = 0 .. n - 1: the
// normalised correlation of what both show, -1 to 1; -1 where they share too little. Thesis (6.18) takes the
// distance of the images themselves; for normalised ones, the least distance is the largest correlation.
std::vector<float> TurnLikeness(const StripReference& then, const StripReference& now);

// The turn to a fraction of a column, from a start that is off by a column or two. Nearer things also shift
// with the place of the camera, as the sine of their azimuth off its way, and the measured verticals err:
// both are estimated with the turn and so do not bend it. By Gauss and Newton, with Tukey's weights.
struct TurnFit {
  bool good = false;    // it came to rest near the start
  double turn = 0;      // rad, clockwise from then to now
  double variance = 0;  // rad^2
  double parallax = 0;  // amplitude, rad
  double likeness = 0;  // correlation at the end
};
TurnFit RefineTurn(const StripReference& then, const StripReference& now, double turn);

}  // namespace kestrel::vision
