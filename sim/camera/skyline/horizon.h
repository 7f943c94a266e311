// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/renderer.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// Where the horizon of a landscape truly is for a camera.
struct HorizonTruth {
  Eigen::Vector3d up_C;  // unit
  double height_m = 0;   // above the ground at the origin, at least 0
  double dip_rad = 0;    // of the free horizon below the horizontal: sqrt(2 h / kEarth_m)
};
HorizonTruth HorizonOf(const Pose& X_NC);

// What each pixel shows: CV_8U. What moves, as the aircraft's own parts, is neither sky nor ground.
enum SkyClass : unsigned char { kGround = 0, kNeither = 128, kSky = 255 };
cv::Mat ClassifySky(const mjModel* model, const Surfaces& surfaces);

// Where a camera on the aircraft sees the aircraft itself: CV_8U, 255 there and two pixels around.
cv::Mat OwnParts(const mjModel* model, const vision::CameraModel& camera, const Pose& X_BC);

// A place where sky and ground are neighbours in a column or in a row: half way between the two pixels, known
// to half a pixel.
struct SkylinePoint {
  Eigen::Vector2d px;
  double azimuth_rad = 0;    // clockwise from north, in (-pi, pi]
  double elevation_rad = 0;  // above the horizontal through the camera
};
// The outline between sky and ground of an image of those classes, row after row.
std::vector<SkylinePoint> TrueSkyline(const cv::Mat& classes, const vision::CameraModel& camera,
                                      const Pose& X_NC);

}  // namespace kestrel::sim
