// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/diagnostics.h"
#include "base/yaml/config.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// What a camera on the ground and the flight do not allow together: a start that it does not see, or sees too
// small; a camera without colour, times that end before they begin. where: the file.
void CheckGround(const sim::GroundCameraParameters& ground, const sim::StartParameters& start,
                 double pad_yaw_deg, const Config& config, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
