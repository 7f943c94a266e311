// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// VINS and camodocal: model_type PINHOLE, PINHOLE_FULL, MEI or KANNALA_BRANDT with projection_parameters (or
// mirror_parameters).
Keys VinsCameras(const ConfigNode& root);
void FromVins(const ConfigNode& root, std::size_t index, Sheet& sheet);

}  // namespace kestrel::vision
