// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::vision {

// Each pixel of an image, CV_8UC1, by how far it is from the mean of the square of side_px, odd, around it, in standard
// deviations there: CV_32FC1. Half of a pad in the shade looks as the half in the sun. A deviation of less than 2 grey
// levels counts as 2, so that noise is not made large. Where a mask, CV_8UC1, is given, the mean and the deviation are
// those of its pixels alone; a pixel with none of them around it is 0.
cv::Mat EvenlyLit(const cv::Mat& grey, int side_px, const cv::Mat& mask = {});

}  // namespace kestrel::vision
