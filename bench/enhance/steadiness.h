// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bench/enhance/shaken_clip.h"
#include "vision/enhance/stabilisation/view_warp.h"

namespace kestrel::bench {

// How the view of each image of a clip came out, judged by the clip's true path.
struct Steadiness {
  double jitter_in_px = 0, jitter_px = 0;  // RMS of the corners against the intended path, from 0.5 to 15 Hz
  double stability = 0, stability_in = 0;  // share of the corners' paths in their lowest frequencies
  double distortion = 1;               // the worst ratio of the two singular values of an image's linear part
  double crop = 0;                     // mean share of the image's width that is shown
  double skew_in_px = 0, skew_px = 0;  // RMS of what no similarity explains of the rows' times
  double outside = 0;                  // mean share of the view that no pixel of the image fills

  double Jitter() const { return jitter_px / jitter_in_px; }
  double Skew() const { return skew_px / skew_in_px; }
};

// views: of images first, first + 1, ...; each as it was shown.
Steadiness SteadinessOf(const ShakenClip& clip, int first, const std::vector<vision::ImageView>& views);

// RMS of a path, evenly sampled, between two frequencies: of its cosine transform, after its straight line is taken out.
double BandRms(std::vector<double> path, double rate_hz, double from_hz, double to_hz);

}  // namespace kestrel::bench
