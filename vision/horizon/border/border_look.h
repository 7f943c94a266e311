// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/horizon/border/plane_view.h"

namespace kestrel::vision {

// A place on the border, found on its own.
struct BorderPoint {
  double along = 0;     // px from the foot of the middle of the view on the line
  double above = 0;     // px over the fitted line
  double contrast = 0;  // of the colours right above and right below, grey levels of all channels
  double weight = 0;    // how far it is believed to lie on the line, 0 to 1
};

// A line after a close look at it: fitted to where the colours change from those of the sky to those of the ground.
struct BorderLook {
  SkyBorder line;
  std::vector<BorderPoint> points;
  double shown = 0;     // columns across the line that are in view, px along it
  double found = 0;     // share of those with a border in them
  double straight = 0;  // share of those whose border lies within a third of a degree of the line
  double near = 0;      // within about one degree
  double scatter = 0;   // of the points on the line, px
  double contrast = 0;  // median, grey levels of all channels
  double sharp =
      0;  // of the change over some 14 px, how much lies within 4: a third in the middle of a slow change
  double steady = 0;  // how far the steps along the line are of one colour: 1 if all are
  double rough_above = 0, rough_below = 0;  // median roughness near the line, grey levels
  double drift = 0;     // of the colours above, over some three degrees, grey levels of all channels
  double brighter = 0;  // above than below near the line, grey levels
};

// topmost: to the place where the sky ends, which may lie above the plainest edge: haze and far hills are no sky. Not
// so, the plainest edge. None: too little of the line is in view.
std::optional<BorderLook> LookAtBorder(const PlaneView& plane, const cv::Mat& view, const SkyBorder& about,
                                       bool topmost);

}  // namespace kestrel::vision
