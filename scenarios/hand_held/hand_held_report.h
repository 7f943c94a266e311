// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "geometry/truth.h"
#include "mission/decision.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::scenarios {

struct HandHeldReport final : mission::MissionReport {
  Pose X_BC;
  std::optional<vision::PadObservation> seen, chained;  // none: the landmark is lost
};

// The axes of the motion capture of thesis 3.4: x to the right and y ahead of who faces the wall, here east
// and north, z up, of the origin of N. Yaw turns about z, from looking along y, to the left positive.
struct RoomPlace {
  Eigen::Vector3d p;  // m
  double yaw;         // rad
};
inline RoomPlace InRoom(const Pose& X_NC) {
  const Eigen::Vector3d axis_N = X_NC.R * Eigen::Vector3d::UnitZ();
  return {{X_NC.p.y(), X_NC.p.x(), -X_NC.p.z()}, -std::atan2(axis_N.y(), axis_N.x())};
}

// Where the camera was at the exposure, by the motion capture, and by an observation of the landmark, of
// whose place the motion capture knows.
inline Pose TrueCamera(const Truth& exposure, const HandHeldReport& report) {
  return exposure.X_NB * report.X_BC;
}
inline Pose SeenCamera(const Truth& exposure, const vision::PadObservation& seen) {
  return exposure.X_NT * seen.X_CT.Inverse();
}

}  // namespace kestrel::scenarios
