// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "geometry/pose.h"
#include "sim/camera/camera_clock.h"
#include "sim/camera/frame_renderer.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/camera/vibration.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::sim {

// A camera that the aircraft carries beside the one that the flight is flown by.
struct CarriedCameraParameters {
  std::string name;  // of no other
  vision::CameraModel camera;
  vision::CameraMount mount;
  ImageParameters image;
  CameraTiming timing;  // with image.rate_hz of whose clock triggers it: the same instants to the step
};

// What is the same for all cameras of a flight.
struct CarriedCameraOptions {
  bool images = true;     // false: nothing is drawn
  bool surfaces = false;  // and flow, with each frame
  bool draw_beside = true;
};

// A frame of it that has come.
struct CameraFrame {
  std::string name;     // of the camera
  vision::Frame frame;  // its sequence counts this camera's exposures
  Pose X_NC;            // the truth at the exposure, shaken as the mount is
  Surfaces surfaces;    // if asked for
  cv::Mat flow;         // px by which what was in its frame before has moved; empty: not asked for, the first
};

// The camera in the world that a Simulator steps. What it shows depends on the world and on its own
// parameters, name and seed, not on which other cameras there are.
class CarriedCamera {
 public:
  // The model must outlive it. Throws what the Renderer throws.
  CarriedCamera(const mjModel* model, const CarriedCameraParameters& parameters, const RenderOptions& render,
                std::uint64_t seed, double duration_s, const CarriedCameraOptions& options);

  // After each step of the world, and at its beginning. X_NB: the truth after it.
  void Step(const mjData* data, std::int64_t step, const Pose& X_NB, double daylight);

  // The earliest frame that has come and was not taken yet, waiting for its image; none: there is none.
  std::optional<CameraFrame> Take();

 private:
  const mjModel* model_;
  std::string name_;
  double dt_s_;
  Pose X_BC_;
  ImageParameters image_;  // with the camera's scatter drawn
  Vibration vibration_;
  CameraClock clock_;
  std::unique_ptr<FrameRenderer> renderer_;  // null: without images
  std::int64_t step_ = 0;
  std::deque<Pose> exposures_;  // X_NC, of the frames under way
};

}  // namespace kestrel::sim
