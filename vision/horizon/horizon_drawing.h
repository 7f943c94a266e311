// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/horizon/border/skyline_fix.h"
#include "vision/horizon/visual_compass.h"

// What the attitude from the skyline saw, drawn for people.
namespace kestrel::vision {

// The small circle at an elevation over the horizontal, rad, as a line in the image (CV_8UC3).
void DrawSmallCircle(cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& down_C,
                     double elevation, const cv::Scalar& colour, int thickness = 1);

// The contour (bright where it is taken for the horizon, dark where something stands before it) and the fitted
// circle.
void DrawSkyline(cv::Mat& image, const CameraModel& camera, const SkylineFix& fix);

// An artificial horizon in a disc of the given radius: sky, ground, pitch ladder by tens of degrees, roll; about
// it a ring in the colour of what the attitude is by.
void DrawArtificialHorizon(cv::Mat& image, cv::Point centre, int radius_px, const RollPitch& attitude,
                           const cv::Scalar& ring);
inline constexpr int kHorizonRadius_px = 52,
                     kHorizonMiddle_px = 62;  // of that of DrawHorizon, from its corner

// A strip with a mark for every ten degrees about the heading, and the heading's number, 0 to 359.
void DrawCompassStrip(cv::Mat& image, cv::Rect place, double heading);

// All of these on a colour copy of the image.
cv::Mat DrawHorizon(const cv::Mat& image, const CameraModel& camera, const Eigen::Matrix3d& R_BC,
                    const SkylineResult& skyline, const std::optional<CompassResult>& compass);
// The numbers of that, or the reasons why there are none: of the attitude, and of the heading.
std::vector<std::string> HorizonWords(const Eigen::Matrix3d& R_BC, const SkylineResult& skyline,
                                      const std::optional<CompassResult>& compass);

}  // namespace kestrel::vision
