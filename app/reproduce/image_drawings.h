// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

namespace kestrel::app {

// Pictures that are drawn from the images of a flight. Thesis figure 6.7, what: views (an image, the same on the unit
// sphere and as a perspective camera would have it). Figures 6.9 to 6.13, by the thesis's own method
// (vision/horizon/baseline/skyline_baseline.h): segmentation (image, sky weight, its segments, ground), ellipse
// (fitted to the ground), sphere (that on the unit sphere), unwrapped (two images in a row between which the
// aircraft turned most) or distance (of those two, against the shift). Throws std::runtime_error where there is
// nothing to draw from, such as no horizon in any image.
void DrawFromImages(const std::string& what, const std::vector<cv::Mat>& images,
                    const vision::CameraModel& camera, const Pose& X_BC, const std::filesystem::path& png);

}  // namespace kestrel::app
