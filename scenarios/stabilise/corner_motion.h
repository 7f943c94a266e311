// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mission/log_row.h"

namespace kestrel::scenarios {

// How what is truly seen at the four corners of the view moved from one image to the next, px of the view: on the
// ground, z = 0 of N, by the true poses of the camera.
struct CornerFlow {
  double t_s = 0;  // of the exposure of the later image
  std::array<Eigen::Vector2d, 4> in,
      out;  // in a view that stands still in the image, as large; in the stabilised
};

// Of the longest run of images without a gap.
std::vector<CornerFlow> CornerFlows(const std::vector<mission::LogRow>& rows);

// The spectrum of a path by its steps: amplitudes at k periods in the time of the steps, k = 0, 1, ..., where that of 0
// is 0. A Hann window is laid over the steps, so that beginning and end leave no trace; it spreads a tone over three
// amplitudes, whose squares add up to that of the tone's own.
std::vector<double> PathAmplitudes(const std::vector<double>& steps);

// The root mean square of a path within a band of frequencies, by its steps.
double BandRms(const std::vector<double>& steps, double rate_hz, double from_hz, double until_hz);

}  // namespace kestrel::scenarios
