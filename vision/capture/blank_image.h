// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::vision {

// A cap on the lens, the night, a white-out: nothing in the image differs from the rest by more than noise,
// so that what is not in it may well be there. True of an empty image too.
bool Blank(const cv::Mat& image);  // CV_8U, any channels

}  // namespace kestrel::vision
