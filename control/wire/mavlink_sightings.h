// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "control/sighting.h"
#include "control/wire/mavlink_dialects.h"

// A sighting as the messages by which an autopilot flies by it. Sources: MAVLink's "common" and "development" sets;
// PX4's guides on external positions and on landing precisely, ArduPilot's on non-GPS position and precision landing.
namespace kestrel::control::wire::mavlink {

// Of the target, for landing. X_NB: the aircraft by the autopilot's own state, at the exposure.
LandingTarget ToLandingTarget(const Sighting& sighting, const Pose& X_NB, const Dialect& dialect);
// In NED with the origin in the aircraft, whose attitude is the autopilot's own.
TargetRelative ToTargetRelative(const Sighting& sighting, const Eigen::Quaterniond& R_NB);

// The pose in T, as a local frame of its own heading (MAV_FRAME_LOCAL_FRD). The velocities are NaN, which PX4 takes
// for unknown and ArduPilot does not.
Odometry ToOdometry(const Sighting& sighting);
// The pose in axes of N about the target, which are had by the autopilot's own heading: only the place is news to it.
VisionPositionEstimate ToVisionPosition(const Sighting& sighting, double yaw_NB);

}  // namespace kestrel::control::wire::mavlink
