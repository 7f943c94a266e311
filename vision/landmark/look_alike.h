// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// How much what lies where H_w puts the pad, or a few percent of its size beside, looks like it: the correlation of both
// seen coarsely, some 60 px wide and with the light evened out, in a fifth of a millisecond. Ground alone has 0.03 to
// 0.16; 1 where too little of the pad is in view to tell. A low one rules the pad out before anything dearer is tried.
double CoarseLikeness(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

// Whether what lies there in an image (CV_8UC1) is rather a mirror image of the pad: of its outline and its
// frames, which are the same, neither detector tells. H_w: from T, m, to the image.
bool LooksMirrored(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

// Whether the rim of the pad, as far as it is in view and has marks, shows in the image where H_w puts it. Where it
// does not, what was found is a part that repeats, at another of its places. True where there is nothing to compare.
bool RimAgrees(const cv::Mat& grey, const PadReference& reference, const Eigen::Matrix3d& H_w);

}  // namespace kestrel::vision
