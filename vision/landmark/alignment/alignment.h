// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "vision/landmark/alignment/warp.h"

namespace kestrel::vision {

// How a step is found. Forward additive: by the image's gradient, after Lucas and Kanade, thesis (3.2) to
// (3.5). Inverse compositional (ICIA; Baker and Matthews 2004, Buenaposada et al. 2003): by the template's, so
// that the Hessian stays the same. Second order (ESM, Benhimane and Malis 2004): by the mean of both.
enum class AlignmentMethod { kForwardAdditive, kInverseCompositional, kSecondOrder };

// The weight w of thesis (3.1) by the residual, in units of a sigma that is taken from the median: Huber
// beyond 1.345, Tukey's biweight up to 4.685. Huber's by itself does not hold against what hides a fifth of the
// template. A quarter hidden misleads Tukey's at coarse levels too:
// with two levels and a start within some 3 px they find it.
enum class AlignmentLoss { kSquares, kHuber, kTukey };

struct AlignmentOptions {
  AlignmentMethod method = AlignmentMethod::kInverseCompositional;
  WarpModel warp = WarpModel::kHomography;
  bool light = true;  // grey of the image = gain * grey of the template + offset, both estimated
  AlignmentLoss loss = AlignmentLoss::kSquares;
  int levels = 4;                // of the template's pyramid, at most
  int min_side_px = 12;          // of its coarsest level
  int max_iterations = 30;       // at each level
  double settled_px = 0.01;      // it has settled when a step moves no corner further
  double min_in_view = 0.2;      // share of the template
  double min_correlation = 0.6;  // with what it settles on
};

enum class AlignmentState {
  kConverged,
  kDiverged,   // it did not settle, or what it settled on does not look like the template
  kLeftImage,  // too little of the template lies in the image
};
std::string_view NameOf(AlignmentState state);

struct Alignment {
  AlignmentState state = AlignmentState::kDiverged;
  Eigen::Matrix3d W = Eigen::Matrix3d::Identity();  // from the template's picture to the image, px
  double correlation = 0;                           // normalised, of what is in view, as weighted
  double rms_grey = 0;                              // of the residual in the image, as weighted
  double in_view = 0;                               // share of the template
  double agreeing = 0;                              // mean weight of what is in view
  double gain = 1, offset = 0;                      // of the light
  int iterations = 0;                               // at all levels together
};

}  // namespace kestrel::vision
