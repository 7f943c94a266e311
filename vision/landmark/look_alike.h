// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// Whether the pad may be where H_w puts it, or a few percent of its size beside: its picture and what lies there are
// compared coarsely, some 60 px wide and with the light evened out, in a fifth of a millisecond. Of 880 places at which
// tests and landings found a pad in even light or blurred, the least alike correlated by 0.64; ground alone does by
// 0.03 to 0.16. True where too little of it is in view to tell.
bool MayBeThere(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

// Whether what lies there in an image (CV_8UC1) is rather a mirror image of the pad: of its outline and its
// frames, which are the same, neither detector tells. H_w: from T, m, to the image.
bool LooksMirrored(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

// Whether the rim of the pad, as far as it is in view and has marks, shows in the image where H_w puts it. Where it
// does not, what was found is a part that repeats, at another of its places. True where there is nothing to compare.
bool RimAgrees(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

}  // namespace kestrel::vision
