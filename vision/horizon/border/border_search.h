// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/horizon/border/plane_view.h"

namespace kestrel::vision {

// Straight lines that could be the border between sky and ground, best first: all of them are scored by how
// much better two bodies of colour and roughness explain the view than one does (Ettinger et al. 2002), and by
// the edge along them.
struct BorderCandidate {
  SkyBorder line;
  double score = 0;
};

// view: CV_8UC3; shown: CV_8UC1 of its size. up: where the sky is, as far as it is known, and how far from it it
// can be (rad).
std::vector<BorderCandidate> SearchBorders(const cv::Mat& view, const cv::Mat& shown,
                                           const Eigen::Vector2d& up, double reach, std::size_t most);

// What lies on the two sides of a line, over all of the view.
struct BorderSides {
  double share_above = 0, share_below = 0;  // of the view
  double gain = 0;                          // how much better two bodies explain it than one, nats per cell
  double rough_above = 0, rough_below = 0;  // mean of log (1 + deviation of the grey within a cell)
  double bright_above = 0, bright_below = 0, blue_above = 0, blue_below = 0;  // grey levels; blue over red
  double green_above = 0, green_below = 0;                                    // green over the other two
};
BorderSides SidesOf(const cv::Mat& view, const cv::Mat& shown, const SkyBorder& line);

}  // namespace kestrel::vision
