// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/landmark/alignment/image_pyramid.h"
#include "vision/landmark/alignment/warp.h"

namespace kestrel::vision {

// What an image is explained by, pixel by pixel: grey = gain * centred + offset + gain * (steepest descent) *
// step. The columns are the pixels, row after row of the template; the rows are these ten.
enum DesignRow { kGainRow = 0, kOffsetRow = 1, kFirstWarpRow = 2, kDesignRows = 10 };
// Two numbers of each pixel.
using PixelPairs = Eigen::Matrix<float, 2, Eigen::Dynamic, Eigen::RowMajor>;
using Design = Eigen::Matrix<float, kDesignRows, Eigen::Dynamic, Eigen::RowMajor>;
using DesignMatrix = Eigen::Matrix<double, kDesignRows, kDesignRows>;
using DesignVector = Eigen::Matrix<double, kDesignRows, 1>;

// The template at one scale, with all that does not depend on an image. Its normal coordinates have their
// origin in the middle, and half the longer side for unit.
struct TemplateLevel {
  int level = 0;                       // of the picture's pyramid
  int cols = 0, rows = 0;              // px of this level
  Eigen::Matrix3d normal_from_pixel;   // pixel (x, y) of this template level, (0, 0) its first
  PixelPairs normal;                   // of each pixel
  PixelPairs gradient;                 // of the grey by the normal coordinates
  Design design;                       // with the steepest descent images of thesis (3.4) at the identity
  DesignMatrix hessian;                // thesis (3.5): of all pixels
  double mean_grey = 0, variance = 0;  // of the grey; `centred` is the grey less its mean
};

// The levels of a template, the finest first: of the pixels of `region` of the picture whose pyramid this is.
// Coarser ones have at least min_side_px on their shorter side; there is always one.
std::vector<TemplateLevel> MakeTemplateLevels(const ImagePyramid& picture, const cv::Rect& region, int levels,
                                              int min_side_px);

}  // namespace kestrel::vision
