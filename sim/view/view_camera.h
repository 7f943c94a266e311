// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <optional>

#include "geometry/pose.h"
#include "geometry/truth.h"
#include "sim/view/view_parameters.h"
#include "sim/world/scene.h"

namespace kestrel::sim {

// Where a view is seen from at one instant.
struct ViewAim {
  Pose X_NC;           // optical: x right, y down, z forward
  double fov_rad = 0;  // over the width of the picture
};

// The radius of the sphere about the aircraft's origin that holds what is seen of it.
double AircraftRadius_m(const mjModel* model);

// Leads a view's camera by where the aircraft truly is. The same truths give the same aims, bit for bit.
class ViewCamera {
 public:
  // model: with a body "vehicle". It must outlive it.
  ViewCamera(const mjModel* model, const ViewParameters& parameters);

  // In the order of time.
  ViewAim At(const Truth& truth);

 private:
  struct Followed {  // softly
    double t_s;
    Eigen::Vector3d p;      // the aircraft, in N
    Eigen::Vector2d ahead;  // its heading
  };
  void Begin(const Truth& truth);
  void Follow(const Truth& truth);
  ViewAim FromTower(const Eigen::Vector3d& aircraft) const;
  // From there the aircraft is seen: nothing that stands in the world is between. Otherwise nearer.
  Eigen::Vector3d InSight(const Eigen::Vector3d& place, const Eigen::Vector3d& aircraft) const;

  const mjModel* model_;
  DataPtr still_;  // the world without what moves
  ViewParameters parameters_;
  double radius_m_, distance_m_;
  std::optional<Followed> followed_;
  double begin_s_ = 0;
  Eigen::Vector3d tower_ = Eigen::Vector3d::Zero();
};

}  // namespace kestrel::sim
