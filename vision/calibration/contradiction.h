// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "vision/calibration/agreeing_views.h"

// Images that are not of the camera of the others, as after a change of focus or zoom.
namespace kestrel::vision {

// What a view would gain by a focal length and a centre of its own, with its pose adjusted too.
struct OwnCamera {
  double explained = 0;     // share of its sum of squares that this takes away, 0 to 1
  double chance = 1;        // that noise alone takes away so much, by Fisher's F
  double focal_change = 0;  // of its focal length over that of the others, less 1
  // The share that as many numbers of another kind take away: a bend of the board in this view alone, a quadratic.
  double by_bend = 0;
};
std::vector<OwnCamera> OwnCameras(const Adjustment& adjustment);

// A view contradicts the others if a camera of its own explains more than half of what is left of it, more than a
// bend of the board does, and noise does so once in 100 000 views.
bool Contradicts(const OwnCamera& own);

// Leaves out the views that contradict the others, the worst first, and adjusts again each time; but none if more
// than a third would be, as of two cameras. left_out: of the usable views, why. Returns how many contradict.
std::size_t LeaveOutContradicting(Agreeing& agreeing, const std::vector<int>& free,
                                  std::vector<std::string>& left_out);

}  // namespace kestrel::vision
