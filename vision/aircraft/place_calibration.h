// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/pose.h"

namespace kestrel::vision {

// The aircraft at one instant, as another source has it and as the camera on the ground saw it. The other source is
// the camera on board, which measures it over the pad, or the autopilot's own navigation; its frame, T or N, is
// the one in which the mast is found.
struct PlaceSighting {
  Eigen::Vector3d p_TB = Eigen::Vector3d::Zero();  // m
  double sigma_m = 0.03;                           // of each coordinate
  Eigen::Vector3d p_GB = Eigen::Vector3d::Zero();  // m; its direction is the bearing, its length the range
  double bearing_sigma = 3e-4;                     // rad, across the line of sight
  double range_sigma_m = 0.3;
};

enum class PlaceState {
  kFound,
  kTooFew,    // sightings
  kNotSpread  // the aircraft was too near to one line through the air, about which the mast may turn
};
const char* NameOf(PlaceState state);

struct PlaceCalibration {
  PlaceState state = PlaceState::kTooFew;
  Pose X_TG;
  // Of the position in T, then of a turn in T: m, rad.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  double residual = 0;  // root mean square of what is left, in sigmas
  int sightings = 0;    // that were believed
};

// Where the mast stands, from an aircraft that flew about before it: bearings and ranges in least squares, with
// Huber's weights, from where the two clouds of places are laid on each other. The errors of the other source are
// not white: of sightings within memory_s only one counts in the covariance. period_s: between two sightings.
PlaceCalibration CalibratePlace(const std::vector<PlaceSighting>& sightings, double period_s,
                                double memory_s = 1);

}  // namespace kestrel::vision
