// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

namespace kestrel::app {

// Thesis figures 6.9 to 6.13, by its own method (vision/horizon/baseline/skyline_baseline.h), from the images of a flight.
// what: segmentation (image, sky weight's segments, ground), ellipse (fitted to the ground), sphere (that on the
// unit sphere), unwrapped (two images in a row between which the aircraft turned most) or distance (of those two,
// against the shift). Throws std::runtime_error where the method finds no horizon in any image.
void DrawHorizonItem(const std::string& what, const std::vector<cv::Mat>& images,
                     const vision::CameraModel& camera, const Pose& X_BC, const std::filesystem::path& png);

}  // namespace kestrel::app
