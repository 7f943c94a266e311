// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/camera_clock.h"
#include "sim/camera/frame_renderer.h"
#include "sim/camera/pan_tilt.h"
#include "sim/camera/renderer.h"
#include "sim/ground/ground_view.h"
#include "vision/aircraft/aircraft_lights.h"
#include "vision/aircraft/ground_camera.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

struct GroundCameraParameters {
  vision::CameraModel camera;
  vision::GroundPlace place;      // as flight code believes it
  vision::AircraftLights lights;  // that the aircraft then has
  GroundViewParameters view;
};

// The camera on the ground in the world that a Simulator steps.
class SimulatedGroundCamera final : public vision::GroundCamera {
 public:
  // X_NT: the pad, beside which it stands. The model must outlive it and have a blind if it is ever blocked
  // (SceneParameters). Throws what the Renderer throws.
  SimulatedGroundCamera(const mjModel* model, const Pose& X_NT, const GroundCameraParameters& parameters,
                        const RenderOptions& render, std::uint64_t seed, double duration_s, bool draw_beside);

  // After each step of the world, and at its beginning: turns the head, puts the blind where it belongs, exposes.
  void Step(mjData* data, std::int64_t step, double daylight);

  std::optional<vision::GroundFrame> Take() override;
  void Turn(const vision::PanTilt& to) override { wanted_ = {to.pan, to.tilt}; }

  Pose X_NC() const;  // the truth, now
  // At the exposure of the frame that Take() gave last.
  const Pose& taken_X_NC() const { return taken_X_NC_; }

 private:
  struct Gazed {  // at an exposure
    PanTiltAngles at;
    Pose X_NC;
  };
  bool Blocked(double t_s) const;

  const mjModel* model_;
  GroundViewParameters view_;  // with the camera's scatter drawn
  double dt_s_;
  Pose X_NG_;  // of the mast, the truth
  PanTiltAngles angles_, wanted_;
  CameraClock clock_;
  FrameRenderer renderer_;
  std::int64_t step_ = 0;
  std::deque<Gazed> gazed_;  // at the exposures of the frames under way
  Pose taken_X_NC_;
};

}  // namespace kestrel::sim
