// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "flight/simulated/scenario.h"
#include "geometry/pose.h"
#include "sim/camera/renderer.h"
#include "sim/world/scene.h"
#include "vision/camera/camera_model.h"

namespace kestrel::bench {

// A scenario's world, seen by the scenario's own camera or by another in its place; nothing flies.
class TimedScene {
 public:
  // Throws InputError.
  explicit TimedScene(const std::string& scenario, const std::optional<vision::CameraModel>& camera = {});
  cv::Mat Draw(const Pose& X_NB);  // CV_8UC3
  const vision::CameraModel& camera() const { return camera_; }
  const Pose& X_BC() const { return X_BC_; }
  cv::Mat OwnParts() const;  // where the camera sees the aircraft

 private:
  flight::LoadedScenario loaded_;
  vision::CameraModel camera_;
  Pose X_BC_;
  sim::ModelPtr model_;
  sim::DataPtr data_;
  sim::Renderer renderer_;
};

// A path over the ground, at this height, one step an image: it turns, sways and goes on.
Pose PathPose(double height_m, int step);

}  // namespace kestrel::bench
