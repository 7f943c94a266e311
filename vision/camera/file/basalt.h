// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// Basalt's JSON (value0.intrinsics), and YAML with a map camera_0, camera_1, ... for each of its cameras: ds, eucm, ucm,
// kb4, fov, pinhole-radtan8 and pinhole.
Keys BasaltCameras(const ConfigNode& root);
void FromBasalt(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
