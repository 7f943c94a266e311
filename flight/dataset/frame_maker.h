// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "flight/dataset/boxes.h"
#include "flight/dataset/format/sequence.h"
#include "flight/dataset/trajectory/trajectory.h"
#include "sim/camera/carried/carried_camera.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/camera/snapshots.h"
#include "sim/render/rendering.h"
#include "sim/world/scene.h"
#include "sim/world/target.h"

namespace kestrel::flight {

// What draws for one camera.
struct FrameMakerParameters {
  std::size_t number = 0;  // of the camera
  sim::CarriedCameraParameters camera;
  sim::RenderOptions render;
  std::vector<sim::TargetParameters> targets;  // at rest
  std::uint64_t seed = 1;                      // of the scenario
};

// Of its noise and its shaking: of each camera its own.
std::uint64_t SeedOf(const FrameMakerParameters& parameters);

// Draws what a camera of an aircraft sees that is put along a trajectory. Each frame depends on its stamp
// alone. One for each thread.
class FrameMaker {
 public:
  // model: of the scenario's scene with its targets. All must outlive it.
  FrameMaker(const mjModel* model, const FrameMakerParameters& parameters, const Trajectory& trajectory,
             const Extras& extras);

  // next_ns: none: there is no flow from the last frame.
  SetFrame Make(int index, std::int64_t stamp_ns, std::optional<std::int64_t> next_ns);

 private:
  sim::Snapshot SnapshotAt(std::int64_t t_ns);

  const mjModel* model_;
  const FrameMakerParameters& parameters_;
  const Trajectory& trajectory_;
  Extras extras_;
  sim::DataPtr data_;
  sim::ImageParameters image_;
  sim::Renderer renderer_;
  sim::ImageSensor sensor_;
  sim::SnapshotInterpolator interpolator_;
  BoxFinder boxes_;
};

}  // namespace kestrel::flight
