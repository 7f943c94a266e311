// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>

#include "geometry/pose.h"
#include "sim/aircraft/rotor/wrench.h"

namespace kestrel::sim {

// A body with a free joint in a MuJoCo model: an aircraft.
class FreeBody {
 public:
  // Writes mass and inertia, about the axes of B, into the model; the origin of the body becomes its centre
  // of mass. Throws std::invalid_argument if the model has no such body or the body no free joint.
  FreeBody(double mass_kg, const Eigen::Vector3d& inertia_kg_m2, mjModel* model, const char* name);

  Pose X_NB(const mjData* data) const;
  Eigen::Vector3d v_N(const mjData* data) const;
  Eigen::Vector3d w_B(const mjData* data) const;
  // Puts it on the body, at the centre of mass, in place of what xfrc_applied held for it.
  void Push(const Wrench& wrench, mjData* data) const;

 private:
  int body_, position_, velocity_;  // indices into the bodies, qpos and qvel of MuJoCo
};

}  // namespace kestrel::sim
