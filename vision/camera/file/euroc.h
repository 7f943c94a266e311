// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// sensor.yaml of one camera of a EuRoC folder, also as TUM-VI and others write it: camera_model, intrinsics,
// distortion_model and distortion_coefficients at its top; T_BS is the camera's pose on the body, which is the
// IMU.
Keys EurocCameras(const ConfigNode& root);
void FromEuroc(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
