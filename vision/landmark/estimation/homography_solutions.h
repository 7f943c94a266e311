// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "vision/landmark/plane/homography.h"

// The solutions of a homography from pairs of points, thesis 3.2.3 (Criminisi et al. 1999). The homogeneous one
// is FitHomography.
namespace kestrel::vision {

// Eq. (3.15), with the element h33 fixed: by elimination for four pairs, by the pseudo-inverse for more. The
// coordinates have the points' centroid as origin and their spread as unit on both sides, so that h33, the
// denominator at the centroid, is zero for no plane in front of a camera. H has unit Frobenius norm. None: fewer
// than four pairs, or a set that leaves H open (three of four on a line, all but one on a line, coincident).
std::optional<Eigen::Matrix3d> FitInhomogeneous(std::span<const PointPair> pairs);

// What the non-linear solution makes least: the sum of squares over the pairs of
enum class GeometricError {
  kSymmetricTransfer,  // d(x', Hx)^2 + d(x, H^-1 x')^2
  kSampson,  // the distance, to first order, of (x, x') from the pairs of points that H takes onto one another
};

// The non-linear solution by Levenberg-Marquardt, from FitHomography or from a start. None: as FitHomography.
std::optional<Eigen::Matrix3d> FitGeometric(std::span<const PointPair> pairs, GeometricError error);
std::optional<Eigen::Matrix3d> RefineHomography(std::span<const PointPair> pairs,
                                                const Eigen::Matrix3d& H_start, GeometricError error);

// The sum itself, px^2 where both sides are in pixels.
double SumOfSquares(std::span<const PointPair> pairs, const Eigen::Matrix3d& H, GeometricError error);

}  // namespace kestrel::vision
