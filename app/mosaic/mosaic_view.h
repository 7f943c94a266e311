// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "vision/enhance/mosaic/mosaic_series.h"

namespace kestrel::app {

// An image and the mosaic that it was added to side by side, as in figure 4.6 of the thesis: on the image the places
// that agreed, and how they moved since the keyframe; on the mosaic, scaled to fit, the outline of the image. CV_8UC3.
cv::Mat MosaicView(const vision::MosaicSeries::Step& step, const vision::Mosaic& mosaic,
                   const cv::Mat& image);

}  // namespace kestrel::app
