// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/camera/pinhole.h"

namespace kestrel::bench {

// The i-th number of the sequence of van der Corput to a prime base; those of several bases are Halton's.
double RadicalInverse(std::uint64_t i, unsigned base);

// Poses of a flat target of size_m before a camera that looks at its centre: over distance (evenly in its
// logarithm), tilt from square to the view, and azimuth of the tilt, by a Halton sequence.
struct PlanePoseStudy {
  vision::Pinhole camera;
  int poses = 2000;
  Eigen::Vector2d size_m = {1.19, 0.91};
  int rows = 6, cols = 5;  // of points, out to the target's rim
  double from_m = 2, to_m = 12;
  double max_tilt_rad = 1.2217;  // 70 degrees
  double sigma_px = 0.3;         // of each coordinate of a pixel
};

inline const std::array<std::string, 5> kPlanePoseMethods = {"homography", "IPPE", "SQPnP",
                                                             "refined from homography", "most likely"};

// Squares of the errors of one estimate, or of the least that any without bias comes to on average.
struct PoseSquares {
  double place_m2 = 0, turn_rad2 = 0;
};

struct PlanePoseTrial {
  double distance_m = 0, tilt_rad = 0;
  double size_px = 0;  // root of the area that the target covers in the image
  PoseSquares bound;   // of Cramer and Rao, from Fisher's information at the true pose
  std::array<std::optional<PoseSquares>, kPlanePoseMethods.size()> errors;  // none: no pose
};

std::vector<PlanePoseTrial> RunPlanePoseStudy(const PlanePoseStudy& study, std::uint64_t seed);

}  // namespace kestrel::bench
