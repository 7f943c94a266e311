// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/camera_faults.h"
#include "sim/camera/frame_renderer.h"
#include "sim/camera/pan_tilt.h"
#include "sim/camera/renderer.h"
#include "sim/camera/snapshots.h"
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

// The camera on the ground in the world that a Simulator steps. Its clock, exposures and latency are kept as
// the Simulator keeps those of the camera on board.
class SimulatedGroundCamera final : public vision::GroundCamera {
 public:
  // X_NT: the pad, beside which it stands. The model must outlive it and have a blind if it is ever blocked
  // (SceneParameters). Throws what the Renderer throws.
  SimulatedGroundCamera(const mjModel* model, const Pose& X_NT, const GroundCameraParameters& parameters,
                        const RenderOptions& render, std::uint64_t seed, double duration_s, bool draw_beside);

  // After each step of the world, and at its beginning: turns the head, puts the blind where it belongs, exposes.
  void Step(mjData* data, std::int64_t step);

  std::optional<vision::GroundFrame> Take() override;
  void Turn(const vision::PanTilt& to) override { wanted_ = {to.pan, to.tilt}; }

  Pose X_NC() const;  // the truth, now
  const Pose& taken_X_NC() const {
    return taken_X_NC_;
  }  // at the exposure of the frame that Take() gave last

 private:
  struct Coming {
    double t_s = 0;
    std::int64_t sequence = 0, due_step = 0;
    PanTiltAngles at;
    Pose X_NC;
  };
  void Tick();
  std::int64_t StepOf(double t_s) const;
  std::int64_t TickStep() const;
  bool Blocked(double t_s) const;

  const mjModel* model_;
  GroundViewParameters view_;  // with the camera's scatter drawn
  double dt_s_, duration_s_;
  Pose X_NG_;  // of the mast, the truth
  PanTiltAngles angles_, wanted_;
  CameraFaults faults_;
  FrameRenderer renderer_;
  std::int64_t half_exposure_ = 0, step_ = 0, tick_ = 0, sequence_ = 0;
  double last_frame_s_ = -1e9;
  std::deque<FrameRequest> open_;
  std::deque<Snapshot> snapshots_;
  std::deque<Coming> coming_;
  Pose taken_X_NC_;
};

}  // namespace kestrel::sim
