// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/plane/homography.h"

// Pose of a plane from its homography to the image, thesis 3.16 to 3.25. The plane is z = 0 of T; H_w takes
// (x, y, 1) of T, m, to a pixel.
namespace kestrel::vision {

// The aspect ratio of a rectangle, width over length, from the homography H' of the unit square to the image,
// eq. (3.21): it needs no size.
double RectangleAspect(const Eigen::Matrix3d& H_unit, const Pinhole& camera);

// X_CT by eq. (3.22) to (3.25). Deviations: lambda is the reciprocal of the mean of both norms of eq. (3.23),
// which noise makes differ, and has the sign that puts the plane in front of the camera. None: H is not of
// such a plane.
std::optional<Pose> PoseFromHomography(const Eigen::Matrix3d& H_w, const Pinhole& camera);

// H_w = K [r1 r2 t], eq. (3.18).
Eigen::Matrix3d HomographyFromPose(const Pose& X_CT, const Pinhole& camera);

struct PlanePose {
  Pose X_CT;
  // Of (translation in C, m; rotation vector in C, rad), when each pixel coordinate has the deviation
  // sigma_px.
  Eigen::Matrix<double, 6, 6> covariance;
  double rms_px = 0;  // root mean square distance of the pairs, px
};

// Fisher's information of noisy pixels of points of the plane, m, on the pose (translation in C, m; rotation
// vector in C, rad), when each pixel coordinate has the deviation 1: no estimate without bias has a smaller
// covariance than sigma_px^2 times its inverse (Cramer and Rao). None: the camera does not see a point.
std::optional<Eigen::Matrix<double, 6, 6>> PoseInformation(std::span<const Eigen::Vector2d> on_plane,
                                                           const Pinhole& camera, const Pose& X_CT);

// The pose that minimises the reprojection error of pairs (plane m, pixel), by Gauss-Newton from a close
// start. Beyond the thesis: eq. (3.24) takes the nearest rotation to what noise made of the columns, in an
// algebraic sense; this takes the most likely pose. sigma_px scales the covariance; it is at least what the
// residual shows.
// What an error that all pixels share adds to the covariance of a pose: to shift the image is to turn the camera
// across its axis. sigma_rad: the shift over the focal length.
Eigen::Matrix<double, 6, 6> CovarianceOfShift(const Pose& X_CT, double sigma_rad);

std::optional<PlanePose> RefinePlanePose(std::span<const PointPair> pairs, const Pinhole& camera,
                                         const Pose& X_CT_start, double sigma_px);

}  // namespace kestrel::vision
