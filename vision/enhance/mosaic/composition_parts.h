// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::vision {

// An image of a mosaic, of a surface all around at each side of its cut.
struct CompositionPart {
  cv::Mat image;
  Eigen::Matrix3d M_WC;
  cv::Rect part;  // of the surface
  double gain = 1;
  // Where it is shown, 255, at a scale of its own; empty: all of it.
  cv::Mat seam;
  cv::Rect seam_part;  // of the surface at that scale
  int seam_halvings = 0;
};

std::vector<CompositionPart> CompositionParts(const Mosaic& mosaic);

// Sets the gains. most_bytes, here and below: of all images together, as small as they are for it.
void BalanceExposures(const Projection& projection, std::int64_t most_bytes,
                      std::vector<CompositionPart>& parts);

// Leaves out images that others show as well, and cuts the rest where they differ least, by graph cuts (Kwatra et
// al. 2003).
void CutSeams(const Projection& projection, std::int64_t most_bytes, std::vector<CompositionPart>& parts);

// Takes the weights of what the seam hides.
void CutBySeam(const CompositionPart& part, int halvings, ProjectedImage& projected);

}  // namespace kestrel::vision
