// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

namespace kestrel::sim {

// MuJoCo spends most of a step on the search for contacts, and an aircraft in the air has none. This has them searched
// for only near what the aircraft may touch: the states are the same to the last bit.
class ContactSearch {
 public:
  // data: with positions computed. Where anything but one free body "vehicle" moves and may touch something, and where
  // the world has options or pairs of contacts of its own, the model stays as it is.
  ContactSearch(const mjModel* model, const mjData* data);

  // Before each mj_step: whether that step is to search. Sets or clears mjDSBL_CONTACT of the model's options.
  void Set(mjModel* model, const mjData* data) const;

 private:
  bool MayTouch(const Eigen::Vector3d& vehicle) const;

  struct Plane {
    Eigen::Vector3d point, normal;
  };
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };
  bool as_it_is_ = false;
  int place_ = 0;      // of the vehicle in qpos
  double radius_ = 0;  // m, about the vehicle's origin: of all of it that may touch, and some room
  std::vector<Plane> planes_;
  std::vector<Ball> balls_;
};

}  // namespace kestrel::sim
