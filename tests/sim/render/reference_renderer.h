// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/renderer.h"
#include "vision/camera/camera_model.h"

// What a camera sees, computed in the slowest and most obvious way, for tests alone: each ray is laid against
// every geom and every triangle, in double. The rules are those of MuJoCo's own OpenGL renderer without
// shadows and reflections, but shapes are exact, light is computed at each point of a surface and not at its
// vertices, and textures are only interpolated: many rays through each pixel do the filtering.
namespace kestrel::sim::reference {

// A surface that a ray meets.
struct Hit {
  double distance_m = 0;
  int geom = -1;
  Eigen::Vector3d normal_M;  // outward
  bool opaque = false;
};

// The image, CV_8UC3 in the order blue, green, red: the mean over n x n rays, evenly spread over each pixel's
// square. Pixels whose centre the lens does not show are black; the parts of others that it does not show do
// not count. With shadows, lights that cast them do not reach opaque surfaces behind others.
cv::Mat Render(const mjModel* model, const mjData* data, const Pose& X_NC, const vision::CameraModel& camera,
               int n, bool shadows = false);

// For each pixel, row after row, all surfaces on the ray through its centre, the nearest first, transparent
// or not, with what they hide; none in the sky and outside of the lens. At the same distance, the geom that
// is drawn later comes first.
std::vector<std::vector<Hit>> Hits(const mjModel* model, const mjData* data, const Pose& X_NC,
                                   const vision::CameraModel& camera);

// How a renderer's Surfaces differ from the nearest opaque surfaces on the rays, inside the lens.
struct SurfaceErrors {
  int other_geom = 0;  // pixels
  double depth = 0;    // worst relative error where the geom is right
};
SurfaceErrors ErrorsOf(const Surfaces& seen, const mjModel* model, const mjData* data, const Pose& X_NC,
                       const vision::CameraModel& camera);

// Where the nearest opaque surface at each pixel's centre goes, px, CV_64FC2: the point moves with its geom
// into the next state, or stays in the same direction if it is sky. NaN where the lens does not show it,
// before or after.
cv::Mat Flow(const mjModel* model, const mjData* data, const Pose& X_NC, const mjData* next_data,
             const Pose& X_NC_next, const vision::CameraModel& camera);

}  // namespace kestrel::sim::reference
