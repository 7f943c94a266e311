// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/pad_tracking.h"

namespace kestrel::vision {

// Heights of a camera above the middle of a pad, m, between which it can find it and follow it.
struct SeenHeights {
  double min_m = 0;  // below, too little of it fits into the image
  double max_m = 0;  // above, it has too few pixels
};

// What a pad is worth for a camera that looks down on its middle, from the lowest range on: one of a picture, of
// tags maybe several with gaps between them. Empty: none. The limits are what the trackers were measured to need:
// 36 px of the shorter side to be found; to be followed, min_inliers corners in the image, or by the method icia a
// sixteenth of the picture; of a tag 3 px to a cell, and all of its square with a cell around it.
std::vector<SeenHeights> HeightsSeen(const PadReference& pad, const Pinhole& camera,
                                     const PadTrackerOptions& options);

}  // namespace kestrel::vision
