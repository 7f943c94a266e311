// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/calibration/agreeing_views.h"

// Which parameters of a camera its images ask for.
namespace kestrel::vision {

// Of a unified camera: fx, fy, cx, cy and xi alone.
inline const std::vector<int> kUndistorted = {0, 1, 2, 3, 4};

// What is found of Parameters(camera).
std::vector<int> FreeParameters(const CameraModel& camera);

// The unified model without its distortion, where that does as well. Of a mirror that is nearly a parabola,
// xi and k1 bend the view alike to the first order: free together, neither is known, and no covariance says
// so. "As well": the distortion's gain is less than Schwarz's criterion asks for (Ann. Statist. 6, 1978).
void DropDistortion(const CameraModel& like, Agreeing& agreeing, std::vector<int>& free);

}  // namespace kestrel::vision
