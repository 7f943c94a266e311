// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/landmark/features/features.h"

namespace kestrel::vision {

// The strongest SURF features of an image, CV_8UC1, by dlib.
Features DetectSurf(const cv::Mat& grey, int max_features);

}  // namespace kestrel::vision
