// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::mission {

// A mosaic as it stands, scaled to fit into a picture of this size, with the outline of its last image in red and
// that image in the upper left corner: a step of thesis figure 4.6. CV_8UC3.
cv::Mat DrawnMosaic(const vision::Mosaic& mosaic, const cv::Mat& image, cv::Size size,
                    const std::string& caption);

// Pictures of one size side by side, in rows of three.
cv::Mat Tiled(const std::vector<cv::Mat>& pictures);

}  // namespace kestrel::mission
