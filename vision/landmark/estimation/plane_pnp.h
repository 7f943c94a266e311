// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "vision/landmark/plane/plane_pose.h"

// Poses of a plane from pairs (plane m, pixel) without a start, beside that of a homography, thesis 3.3. The
// covariance of each is what its pixels, if each coordinate has the deviation sigma_px, leave of the pose at best;
// as in RefinePlanePose, sigma_px is at least what the residual shows. Fewer than four pairs, or points on a line,
// give none.
namespace kestrel::vision {

// Infinitesimal plane-based pose estimation (Collins and Bartoli 2014), by OpenCV. A plane that is far, or nearly
// square to the view, looks almost the same from two poses: both are given, that of the smaller reprojection error
// first, and how near the second's rms_px comes to the first's tells how ambiguous the view is.
std::vector<PlanePose> IppePoses(std::span<const PointPair> pairs, const Pinhole& camera, double sigma_px);

// PnP as a quadratic program (Terzakis and Lourakis 2020), by OpenCV: of its solutions that of the smallest
// reprojection error.
std::optional<PlanePose> SqpnpPose(std::span<const PointPair> pairs, const Pinhole& camera, double sigma_px);

// The most likely pose: the better one of both solutions of IPPE, each refined by RefinePlanePose.
std::optional<PlanePose> MostLikelyPlanePose(std::span<const PointPair> pairs, const Pinhole& camera,
                                             double sigma_px);

}  // namespace kestrel::vision
