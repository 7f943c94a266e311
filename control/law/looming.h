// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// What a camera knows of an encounter without any range: how fast a thing grows and how its bearing turns. In
// the horizontal plane, seen from above: x north, y east.
namespace kestrel::control {

struct Looming {
  double growth =
      0;  // of the angle that a thing covers, over that angle, 1/s: the closing speed over the range
  double bearing_rate = 0;  // against the ground, rad/s, clockwise
};

// p, v: of the other, relative to us, both in the same unit of length, whatever that is.
Looming LoomingOf(const Eigen::Vector2d& p, const Eigen::Vector2d& v);

// The closest point if both fly on as they do.
struct LoomingApproach {
  double after_s = 0;     // 0: they part already
  double miss_share = 1;  // closest distance over the distance now
};
LoomingApproach ApproachOf(const Looming& looming);

}  // namespace kestrel::control
