// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/horizon/band_sampler.h"

namespace kestrel::vision {

// The contour between sky and ground on the meridians of a band: where each stops looking like the ground
// below and starts looking like the sky above it. What the two look like is learnt from the band itself, in
// sectors of azimuth: the side of the sun is another world than the side away from it.
struct ProfileOptions {
  double gap = 0.02;                             // rad on either side of the contour that teach nothing
  double ground_reach = 0.10, sky_reach = 0.15;  // rad from the contour that teach
  int passes = 2;
};

struct ProfilePoint {
  bool shown = false;    // the meridian is in view over most of the band
  bool found = false;    // and has a step in it
  double elevation = 0;  // of the step, rad
  double blur = 0;       // over which the odds turn at the step, rad: haze, hardly less than a sample
  double contrast = 0;   // of the colours right above and right below the step, grey levels of all channels
  double gain = 0;       // how much better the step explains the meridian than either body alone, nats
};

// contour: where the step is about, per azimuth of the grid. Returns one point per azimuth.
std::vector<ProfilePoint> FindContour(const BandSamples& band, const BandGrid& grid,
                                      const std::vector<double>& contour, const ProfileOptions& options);

// How much better the contour's two bodies explain the band than one does, nats per sample: bodies over all
// azimuths, so that a contour which has ground on its upper side anywhere explains less.
double ContourSeparation(const BandSamples& band, const BandGrid& grid,
                         const std::vector<ProfilePoint>& points);

}  // namespace kestrel::vision
