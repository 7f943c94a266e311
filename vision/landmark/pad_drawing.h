// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/pinhole.h"

// What a tracker saw of a pad, drawn for people on an image as the camera gives it, CV_8UC3.
namespace kestrel::vision {

// Small circles at points of the view that the tracker looks through, which has the same C as the camera.
void DrawPoints(cv::Mat& bgr, const CameraModel& camera, const Pinhole& view,
                const std::vector<Eigen::Vector2d>& points, int radius_px, const cv::Scalar& colour);

// The pad's outline, in T, m, as straight as the lens lets it be, and the axes of T: x red, y green, z blue and
// upwards.
void DrawOutlineAndAxes(cv::Mat& bgr, const CameraModel& camera, const Pose& X_CT,
                        const std::vector<Eigen::Vector2d>& outline_T);

}  // namespace kestrel::vision
