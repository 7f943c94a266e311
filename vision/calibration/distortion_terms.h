// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "vision/calibration/agreeing_views.h"

// Which parameters of a camera its images ask for.
namespace kestrel::vision {

// What may be found of Parameters(camera): everything but k3 of Brown and Conrady and skew, which Kalibr's
// models do not have.
std::vector<int> FreeParameters(const CameraModel& camera);

// Holds the distortion at 0 of which the images do not show that it is there, group by group: of a pinhole
// k2, p1 with p2, k1; of a fisheye k4, k3, k2, k1 until one is asked for; of a unified camera all of it, k1
// with k2, p1 with p2. A group is asked for if without it the sum of squares grows by more than Schwarz's
// criterion (Ann. Statist. 6, 1978) wants of so many parameters, times the design effect of Rao and Scott
// (J. Am. Stat. Assoc. 76, 1981) where the errors of an image are alike and each corner tells less. What is
// not asked for is either unknown, and takes others with it (of a lens of 20 deg k3 may be 44 +- 43), or
// nothing. Of a mirror that is nearly a parabola, xi and k1 bend the view alike to the first order: free
// together, neither is known, and no covariance says so. Changes the camera, the poses and `free`.
void DropDistortion(const CameraModel& like, Agreeing& agreeing, std::vector<int>& free);

// The distortion that is held at 0, by name: "k2, p1, p2"; empty: none.
std::string HeldDistortion(const CameraModel& camera, const std::vector<int>& free);

}  // namespace kestrel::vision
