// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// OKVIS: a list of cameras with focal_length, principal_point and distortion_type.
Keys OkvisCameras(const ConfigNode& root);
void FromOkvis(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
