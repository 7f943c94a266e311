// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "geometry/pose.h"
#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// X_IC by the sheet's matrix, or by Basalt's map of px, py, pz, qx, qy, qz, qw; none: there is none, or it is
// no rigid motion, which is a mistake.
std::optional<Pose> PoseOnImu(Sheet& sheet);

}  // namespace kestrel::vision
