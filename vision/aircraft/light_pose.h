// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "vision/aircraft/aircraft_lights.h"
#include "vision/aircraft/light_detector.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

struct LightPoseOptions {
  double spot_sigma_px = 0.25;  // of a spot's centre
  double tilt_sigma_deg = 3;    // of the expected roll and pitch, which the camera's own error adds to
  double max_range_m = 200;
};

// The aircraft as the lights show it.
struct LightPose {
  Pose X_CB;
  Eigen::Matrix<double, 6, 6> covariance;  // of the position in C, then of the attitude, turned in B
  int lights = 0;                          // matched
  double residual_px = 0;                  // root mean square
};

// What is known of the aircraft before the image is looked at.
struct ExpectedAircraft {
  Eigen::Quaterniond R_CB = Eigen::Quaterniond::Identity();
  // Standard deviation of its turn about the vertical, rad; none: any turn is possible, of which R_CB is one.
  std::optional<double> yaw_sigma;
  std::optional<Eigen::Vector3d> p_CB;  // m; none: it may be anywhere
};

// The pose that explains the spots: which spot is which light is not known, some lights are hidden and some spots
// are none of them. Every two spots are taken for every two lights of their colours, which with the attitude
// expected gives the position by linear equations; the pose that most spots agree with is refined over all six
// degrees of freedom, the expected roll and pitch held by their deviation, by the spots that show a whole light. down_C: the vertical about which
// the turn is not known. None: fewer than four lights agree, or fewer than three that were expected there;
// or they do not fit.
std::optional<LightPose> PoseFromLights(const std::vector<LightSpot>& spots, const AircraftLights& lights,
                                        const CameraModel& camera, const ExpectedAircraft& expected,
                                        const Eigen::Vector3d& down_C, const LightPoseOptions& options = {});

}  // namespace kestrel::vision
