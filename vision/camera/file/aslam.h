// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// What aslam_cv's users write, SVO and maplab: a list of cameras, at the top or in a sensor of the type NCAMERA, each
// with type, intrinsics and distortion. Its distortion 'fisheye' is that of one number.
Keys AslamCameras(const ConfigNode& root);
void FromAslam(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
