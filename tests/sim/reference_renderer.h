// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "geometry/pose.h"
#include "vision/camera_model.h"

// What a camera sees, computed in the slowest and most obvious way, for tests alone: each ray is laid against
// every geom and every triangle, in double. The rules are those of MuJoCo's own OpenGL renderer without
// shadows and reflections, but shapes are exact, light is computed at each point of a surface and not at its
// vertices, and textures are only interpolated: many rays through each pixel do the filtering.
namespace kestrel::reference {

// A pixel at its centre. No hit: sky, or black outside the lens.
struct Hit {
  double distance_m = 0;
  int geom = -1;
  Eigen::Vector3d normal_M;  // outward
};

// The image, CV_8UC3 in the order blue, green, red: the mean over n x n rays, evenly spread over each pixel's
// square. Pixels whose centre the lens does not show are black; the parts of others that it does not show do
// not count.
cv::Mat Render(const mjModel* model, const mjData* data, const Pose& X_NC, const CameraModel& camera, int n);

// What is opaque, or transparent and nearer, on the ray of a place in the image; none in the sky and outside
// of the lens.
std::optional<Hit> HitAt(const mjModel* model, const mjData* data, const Pose& X_NC,
                         const CameraModel& camera, const Eigen::Vector2d& uv);

// Where the surface seen at uv goes, px: the point moves with its geom into the next state, or stays in the
// same direction if it is sky. None outside the lens, before or after.
std::optional<Eigen::Vector2d> FlowAt(const mjModel* model, const mjData* data, const Pose& X_NC,
                                      const mjData* next_data, const Pose& X_NC_next,
                                      const CameraModel& camera, const Eigen::Vector2d& uv);

}  // namespace kestrel::reference
