// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/world/additions.h"

namespace kestrel::sim {

inline constexpr int kMaxPhotoSide_px = 16384;

// Lays a photo on the ground, 6 mm high and without contacts, in as many tiles of up to 4096 x 4096 texels as keep its
// resolution. Throws std::runtime_error with one sentence: it is no image, too large, or of other proportions.
void AddGroundPhoto(const GroundPhotoParameters& photo, AdditionsModel& model);

}  // namespace kestrel::sim
