// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/calibration/view_adjustment.h"

// How well the images know a camera.
namespace kestrel::vision {

// The maximum angle between the normals of two boards, rad.
double SpreadOfTilts(const std::vector<AdjustedView>& views);

// One deviation of the pixel of a known ray, the largest over what was seen of the image, after the turn of
// the camera that takes most of it away: where the camera is mounted, the images of a board do not tell, and
// of a narrow lens a shift of the centre is a turn.
double WorstUncertainty(const Calibration& calibration);

inline constexpr double kMaxAlike = 2;  // see AllowForImages; of noise alone it is 0.5 to 1

// How much larger than by independent corners the deviations are where the errors of an image may be alike,
// root mean square over the parameters; if that is much, the covariance becomes the larger one.
double AllowForImages(const Adjustment& adjustment, const std::vector<int>& free, Calibration& calibration);

}  // namespace kestrel::vision
