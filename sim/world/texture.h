// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace kestrel::sim {

// A picture of any size as the bytes of a PNG file that renderers take: its sides are the next powers of two, up to
// 4096, and from edge to edge it shows the same. OpenGL halves other sizes by leaving a row out, so that a thing
// would look smaller from afar. picture: CV_8UC1 or CV_8UC3.
std::string TextureOf(const cv::Mat& picture);
// The same as pixels, of any type.
cv::Mat TexturePicture(const cv::Mat& picture);

}  // namespace kestrel::sim
