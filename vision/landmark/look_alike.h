// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// Whether what lies there in an image (CV_8UC1) is rather a mirror image of the pad: of its outline and its
// frames, which are the same, neither detector tells. H_w: from T, m, to the image.
bool LooksMirrored(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

// Whether the rim of the pad, as far as it is in view and has marks, shows in the image where H_w puts it. Where it
// does not, what was found is a part that repeats, at another of its places. True where there is nothing to compare.
bool RimAgrees(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

}  // namespace kestrel::vision
