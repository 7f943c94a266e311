// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace kestrel::vision {

// Of an image: its grey = gain * (grey of the picture that is seen in it) + offset.
struct Exposure {
  double gain = 1, offset = 0;
};

// Of greys x, as drawn, and y, as seen, of the pixels of a patch.
struct GreySums {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;

  GreySums& operator+=(const GreySums& o);
  double Correlation() const;  // zero-mean, normalised; 0 where one of the two is even
};

struct CornerMatch {
  bool found = false;  // by a shift that converged
  Eigen::Vector2d at;  // in the image, px
  GreySums greys;      // of the patch, drawn in the exposure that was given, and of the image there
};

// Where the corners of a plane's picture are in an image, for homographies that are known to a few px: about each
// corner a patch of 13 px of the picture is drawn as the image would show it, and shifted until the squared
// differences are least, by the inverse compositional form of Lucas-Kanade (thesis 3.1). Beyond the rim of the
// picture lies something of the grey `around`; what lies beyond that of the image does not count.
// picture, image: CV_8UC1. predicted: the corners in the image, px. In their order.
std::vector<CornerMatch> MatchCorners(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_image,
                                      const cv::Mat& image, std::span<const Eigen::Vector2d> predicted,
                                      const Exposure& exposure, double around);

}  // namespace kestrel::vision
