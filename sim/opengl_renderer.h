// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "geometry/pose.h"
#include "sim/gl_context.h"
#include "sim/renderer.h"
#include "vision/pinhole.h"

namespace kestrel {

// Draws what a pinhole camera sees, by OpenGL, from 2 cm to 500 m in front of it. An OpenGlRenderer belongs
// to the thread that made it, and one thread holds one at a time: its context is current there. Several on
// several threads may share the model. The same state gives the same image, bit for bit, with the same
// name().
class OpenGlRenderer {
 public:
  // The model must outlive it. Throws std::runtime_error if no context can be had, if the image is empty or
  // larger than the context draws, or if fx and fy differ by more than 1e-9 of fx: OpenGL by way of MuJoCo
  // draws square pixels only.
  OpenGlRenderer(const mjModel* model, const Pinhole& camera, const RenderOptions& options);
  ~OpenGlRenderer();
  OpenGlRenderer(const OpenGlRenderer&) = delete;
  OpenGlRenderer& operator=(const OpenGlRenderer&) = delete;

  // The image, CV_8UC3 in the order blue, green, red, from the pose X_NC of the camera (optical: x right, y
  // down, z forward). Positions and light of data must be computed (mj_forward or mj_step); data may be a
  // private copy.
  cv::Mat Render(const mjData* data, const Pose& X_NC);

  // The backend, what draws, and its version.
  const std::string& name() const { return name_; }

 private:
  const mjModel* model_;
  Pinhole camera_;
  bool shadows_;
  std::unique_ptr<GlContext> context_;
  std::string name_;
  mjvScene scene_;
  mjvOption visible_;
  mjrContext gpu_;
  cv::Mat rgb_;  // bottom row first, as read back
};

}  // namespace kestrel
