// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include "sim/instrument/instruments.h"

namespace kestrel::sim {

// In the world of these data, whose positions are computed; both must outlive it. What is opaque and what is
// transparent stops it alike, the aircraft does not.
Beam BeamIn(const mjModel* model, const mjData* data);

}  // namespace kestrel::sim
