// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "geometry/pose.h"
#include "sim/render/rendering.h"
#include "sim/render/shared_loop.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// Draws what any central camera sees by casting a ray through each pixel, as the camera's model says, into
// the MuJoCo model: no seams, no resampling, no nearest and no farthest distance. It draws as MuJoCo's own
// OpenGL renderer does: planes, boxes, spheres, capsules, cylinders, ellipsoids, meshes and height fields;
// planar and cube textures, materials, lights, skybox, haze, transparency; light for each pixel. Beyond that:
// - textures are filtered over the footprint of each pixel (trilinear);
// - pixels at edges, and on things thinner than a pixel, are drawn by 8 rays each;
// - round things are round;
// - the sky is infinitely far: it hides nothing but what lies behind haze of an endless plane;
// - a model with the number "visibility_m" (an element <numeric>) is seen through air: what is so far keeps 2 % of
//   its contrast with the sky above the horizon;
// - of transparent meshes and height fields the nearest face shows, and what is transparent casts no shadow.
// With RenderOptions::light sky there are soft shadows, light from the sky and grass: sky_light.h.
// What a pixel shows does not depend on the number of threads. It is compiled for several instruction sets
// and takes the best at run time; name() tells which.
class RayRenderer {
 public:
  // The model must outlive it. Throws std::runtime_error that names what cannot be drawn. shared: in which another
  // thread may help to draw; none: none does. It must outlive it too.
  RayRenderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& options,
              SharedLoop* shared = nullptr);
  ~RayRenderer();

  void SetCamera(const vision::CameraModel& camera);     // from now on; a lens that zooms
  cv::Mat Render(const mjData* data, const Pose& X_NC);  // as in Renderer
  cv::Mat Render(std::span<const SceneState> states, const Shutter& shutter);
  // The same at one instant, in grey and before it is rounded to bytes: CV_32FC1, 0 to 255, 0 outside the
  // lens.
  cv::Mat RenderGrey(std::span<const SceneState> states, double t_s);
  Surfaces Trace(const mjData* data, const Pose& X_NC);
  // How each pixel's surface moves in the image until the next instant: CV_32FC2, px. NaN outside the lens,
  // and where it leaves the lens's field. That something else may come before it meanwhile is not considered.
  // seen_now: as Trace() gives it of `now`.
  cv::Mat Flow(const Surfaces& seen_now, const SceneState& now, const SceneState& next);

  const std::string& name() const { return name_; }

 private:
  struct Stage;
  vision::CameraModel camera_;
  int threads_ = 1;
  std::unique_ptr<Stage> stage_;
  std::string name_;
};

}  // namespace kestrel::sim
