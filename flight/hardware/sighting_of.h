// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "control/autopilot.h"
#include "control/sighting.h"
#include "mission/decision.h"
#include "mission/mission_type.h"

namespace kestrel::flight {

// A mission's fix for an autopilot that flies by it. t_s: of the exposure. The fix has place and heading; roll and pitch
// are of the autopilot's state. The covariance is Cramer's and Rao's of as many points of the pad as the fix has inliers,
// spread over it, in the camera as it is mounted, each with the fix's residual, kMinResidual_px at least: no estimate
// without bias is better, and the camera's calibration and mount are taken for true. Unknown where the camera cannot
// see the pad from there.
inline constexpr double kMinResidual_px = 0.5;
control::Sighting SightingOf(const mission::TargetFix& fix, double t_s, const control::VehicleState& state,
                             const mission::MissionParts& parts);

}  // namespace kestrel::flight
