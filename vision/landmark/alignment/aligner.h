// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/landmark/alignment/alignment.h"
#include "vision/landmark/alignment/image_pyramid.h"
#include "vision/landmark/alignment/light.h"
#include "vision/landmark/alignment/normal_sums.h"
#include "vision/landmark/alignment/patch.h"
#include "vision/landmark/alignment/residual_weights.h"
#include "vision/landmark/alignment/template_level.h"

namespace kestrel::vision {

// Finds a template in images by its grey alone: thesis (3.1), the sum of squared differences over all its
// pixels, from a start that is some pixels off. From coarse to fine, with a warp that is at most affine on the
// coarsest level of several; by Gauss and Newton, damped after Levenberg where a step makes it worse.
// Beyond the thesis: gain and offset of the light, which are unknowns beside the warp and leave the Hessian of
// the inverse algorithm the same; the loss; the scale of the image under the template, which decides the
// level of its pyramid. It takes no memory after its first images.
class Aligner {
 public:
  // The template is what region holds of the picture, CV_8UC1 or CV_32FC1, at least 4 x 4 pixels; what lies
  // around it is used at coarser scales. Asserts that it is so.
  Aligner(const cv::Mat& picture, const cv::Rect& region, const AlignmentOptions& options);

  // W_start: from the picture to the image. The warp found is W_start times one of the model's group, which
  // acts about the template's middle.
  Alignment Align(const ImagePyramid& image, const Eigen::Matrix3d& W_start);

 private:
  struct Fit;
  struct Stage;
  // The level of the image whose pixels are about as large as those of a level of the template.
  int ImageLevel(const Fit& fit, const TemplateLevel& level) const;
  bool Look(const Stage& stage, Fit& fit);  // false: too little in view
  NormalSums Linearise(const Stage& stage, const Fit& fit);
  bool Move(const Stage& stage, const WarpParameters& step, Fit& fit) const;  // false: not a warp any more
  void Settle(const Stage& stage, Fit& fit);

  AlignmentOptions options_;
  std::vector<TemplateLevel> levels_;
  Eigen::Matrix3d normal_from_picture_;
  std::vector<Eigen::Vector2d> corners_;  // of the region, in normal coordinates

  Patch patch_;
  ResidualWeights weights_;
  struct Scratch {
    Design design;
    PatchGradient slope;
  };
  std::vector<Scratch> scratch_;  // of each level; none for the inverse compositional algorithm
};

}  // namespace kestrel::vision
