// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/pad_reference.h"
#include "vision/pinhole.h"

namespace kestrel {

// Finds the whole pad in one image, without any guess: quadrilaterals of the image whose rectangle has the pad's
// aspect ratio (thesis 3.21), compared with the reference appearance in both directions. It stands in for the person
// who clicks four corners in thesis 4.4. Returns H_w, the homography from T, m, to the image, good to about a pixel.
// None: no quadrilateral looks like the pad.
std::optional<Eigen::Matrix3d> DetectPad(const cv::Mat& grey, const PadReference& reference, const Pinhole& camera);

}  // namespace kestrel
