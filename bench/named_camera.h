// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/file/model_files.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::bench {

// One of models/cameras. Throws InputError.
inline vision::CameraModel NamedCamera(const std::string& name) {
  Mistakes mistakes;
  const vision::CameraModel camera =
      vision::LoadCamera(Root() / "models" / "cameras" / (name + ".yaml"), mistakes);
  mistakes.ThrowIfAny();
  return camera;
}

}  // namespace kestrel::bench
