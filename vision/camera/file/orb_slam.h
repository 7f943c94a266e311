// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// ORB-SLAM 2 and 3, and those that have followed it: Camera.fx or Camera1.fx, ..., with Camera.type PinHole,
// Rectified or KannalaBrandt8; without one it is ORB-SLAM2's pinhole.
Keys OrbSlamCameras(const ConfigNode& root);
void FromOrbSlam(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
