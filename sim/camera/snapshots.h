// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <optional>
#include <span>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/renderer.h"
#include "sim/camera/vibration.h"
#include "sim/world/scene.h"

namespace kestrel::sim {

// The state of the world after a step: as much of it as a picture needs.
struct Snapshot {
  double t_s = 0;
  std::vector<mjtNum> qpos, mocap_pos, mocap_quat;
  double daylight = 1;       // as a multiple of the usual
  std::optional<Pose> X_BC;  // of a camera on a platform; none: it is where it was mounted
  std::optional<Pose> X_NC;  // of a camera that is not on the aircraft
};
Snapshot SnapshotOf(const mjModel* model, const mjData* data, double t_s);

// Makes the states of the world within an exposure out of the snapshots around it. The aircraft is the first free joint of the
// model.
class SnapshotInterpolator {
 public:
  // X_BC: the mount, which the vibration shakes. The model must outlive it.
  SnapshotInterpolator(const mjModel* model, const Pose& X_BC, const Vibration& vibration);

  // Those that enclose [from_s, until_s], as far as there are snapshots; never none. They are in the order
  // of time; between two of them the world moves evenly, and there are states in between where the mount
  // shakes. What is returned lasts until the next call.
  std::span<const SceneState> Of(const std::vector<Snapshot>& snapshots, double from_s, double until_s);

 private:
  void Add(double t_s, const Snapshot& before, const Snapshot& after, double share);

  const mjModel* model_;
  mjModel lean_;  // shares its arrays; leaves out of the data made with it what no picture needs
  Pose X_BC_;
  Vibration vibration_;
  std::vector<DataPtr> data_;
  std::vector<SceneState> states_;
};

}  // namespace kestrel::sim
