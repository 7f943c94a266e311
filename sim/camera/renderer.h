// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <variant>

#include "geometry/pose.h"
#include "sim/render/rendering.h"
#include "sim/render/shared_loop.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

class OpenGlRenderer;
class RayRenderer;

// Draws what a camera sees, by one of two means: see RenderOptions. The same states give the same image,
// bit for bit, with the same name().
class Renderer {
 public:
  // The model must outlive it. Throws std::runtime_error with one sentence that names what cannot be drawn. shared: as
  // in RayRenderer; OpenGL draws alone.
  Renderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& options,
           SharedLoop* shared = nullptr);
  ~Renderer();

  // The image, CV_8UC3 in the order blue, green, red; black outside the lens.
  cv::Mat Render(const mjData* data, const Pose& X_NC);
  // The same while the world and the camera move: states in the order of time; between two of them poses
  // are interpolated, beyond the ends the nearest holds.
  cv::Mat Render(std::span<const SceneState> states, const Shutter& shutter);
  Surfaces Trace(const mjData* data, const Pose& X_NC);
  // As in RayRenderer; empty by OpenGL, which cannot tell.
  cv::Mat Flow(const Surfaces& seen_now, const SceneState& now, const SceneState& next);

  // What draws, and its version.
  const std::string& name() const;

 private:
  std::variant<std::unique_ptr<RayRenderer>, std::unique_ptr<OpenGlRenderer>> by_;
};

}  // namespace kestrel::sim
