// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/mosaic/motion_estimate.h"

namespace kestrel::vision {

// Two images that show the same, and where.
struct AdjustmentEdge {
  int a, b;
  std::vector<PixelPair> pairs;
};

// Where an image should be placed, as a pose of the camera says; sigma_px: how far off its pixels may be.
struct AdjustmentPrior {
  int image;
  Eigen::Matrix3d M_WC;
  double sigma_px;
};

struct AdjustmentOptions {
  int most_iterations = 20;  // solutions of the equations, those that are refused too
  double outlier_px = 1;     // a distance at which a pair counts half (Cauchy)
};

struct AdjustmentResult {
  double rms_px = 0;  // of the pairs' distances, each weighted as it counts
  int iterations = 0;
  bool converged = false;
};

// Bundle adjustment of the images of a mosaic: the placements M_WC, homographies of rays or rotations, that make
// least the sum of squares, in pixels of image b, of the distances of the pairs from where a's pixel is seen in b,
// and of the priors at four places of each image. Gauss-Newton with Levenberg's damping, M_WC (I + D) of eight
// numbers or M_WC exp(D) of three for each image (Szeliski 2006, 4 and 5), by sparse Cholesky. Without priors the
// first image stays where it is.
AdjustmentResult AdjustMosaic(MosaicModel model, const CameraModel& camera,
                              const std::vector<AdjustmentEdge>& edges,
                              const std::vector<AdjustmentPrior>& priors, const AdjustmentOptions& options,
                              std::vector<Eigen::Matrix3d>& M_WC);

}  // namespace kestrel::vision
