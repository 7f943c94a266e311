// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::vision {

// Whether an image is woven of two fields of different times, as interlaced video has it: where something moved
// between them, a row is unlike both its neighbours, and like those beyond them. Judged by the image alone, so that
// one in which nothing moved is not told from a whole one, and need not be. CV_8UC1 or CV_8UC3.
bool Interlaced(const cv::Mat& image);

// The image of the first field alone: its rows, and between them their mean.
cv::Mat FirstField(const cv::Mat& image);  // CV_8U, any channels

}  // namespace kestrel::vision
