// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::sim {

// A picture of any size and type as one that renderers take: its sides are the next powers of two, up to 4096, and
// from edge to edge it shows the same. OpenGL halves other sizes by leaving a row out, so that a thing would look
// smaller from afar. It is the picture itself where that is one.
cv::Mat TexturePicture(const cv::Mat& picture);

}  // namespace kestrel::sim
